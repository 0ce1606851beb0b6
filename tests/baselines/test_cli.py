"""The command ``gym-extensions train``: its arguments, the messages about mistakes, and its output."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from gym_extensions.__main__ import main
from gym_extensions.baselines import algorithms
from gym_extensions.baselines.cli import parser

from .train_command import command, replace_train

OWN_AGENT = "Name your own agent as module:factory."
MISTAKES = [
    (command("trop"), f"Unknown agent 'trop'. Did you mean 'trpo'? {OWN_AGENT}"),
    (
        command("trpo", groups="hoper-gravity"),
        "There is no group 'hoper-gravity'. Did you mean 'hopper-gravity'?",
    ),
    (command("trpo", budget="100K"), "There is no budget '100K'. Did you mean '100k'?"),
    (command("trpo", protocol="serial"), "Unknown protocol 'serial'. Did you mean 'sequential'?"),
    (
        command("trpo", runs="1000"),
        "--runs: Run 1000 is out of range. Use 0 to 999; larger numbers are reserved for references.",
    ),
    (
        command("trpo", runs="a"),
        "--runs: 'a' is not a list of runs. Use numbers and ranges, such as 0,1 or 0-4.",
    ),
    (
        command("trpo", runs="0,4-1"),
        "--runs: The range '4-1' is empty. Write the smaller number first: 1-4.",
    ),
    (
        command("zero", out="zero run"),
        "zero run: 'zero run' is not a valid submission name. "
        "Use at most 64 letters, digits, dots, dashes and underscores; start with a letter or digit.",
    ),
    (command("trpo", jobs="0"), "--jobs: 0 is too small. Use at least 1."),
    (command("trpo", num_envs="0"), "--num-envs: 0 is too small. Use at least 1."),
    (command("trpo", num_threads="0"), "--num-threads: 0 is too small. Use at least 1."),
    (
        command("trpo", budget="100k", num_envs="64"),
        "--num-envs: With 64 environments, the budget '100k' has fewer than 10 episodes per environment. "
        "Use at most 10 for hopper-gravity.",
    ),
    (command("trpo", evaluate_every="0"), "--evaluate-every: 0 is too small. Use at least 1."),
    (
        command("trpo", evaluate_every="500", evaluate_episodes="21"),
        "--evaluate-episodes: 21 is too large. Use at most 20, the episodes that have a prescribed seed.",
    ),
    (command("trpo", log="csv,tensorbord"), "log: There is no log 'tensorbord'. Did you mean 'tensorboard'?"),
    (
        command("nowhere:make"),
        "Module 'nowhere' was not found. Run the command in the folder of the module, or install the module.",
    ),
    (
        command("gym_extensions.baselines.algorithms.trpo:mak"),
        "Module 'gym_extensions.baselines.algorithms.trpo' has no callable 'mak'. Did you mean 'make'?",
    ),
    (
        ["reference", "--groups", "hopper-gravity", "--budget", "smoke", "--runs", "3", "--out", "x.json"],
        "--runs: Run 3 is out of range. Use numbers from 1000; smaller ones are reserved for submissions.",
    ),
]


@pytest.mark.parametrize(("argv", "message"), MISTAKES, ids=[row[1][:40] for row in MISTAKES])
def test_a_mistake_is_reported_before_anything_runs(
    argv: list[str],
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(argv) == 2
    assert capsys.readouterr().err == f"error: {message}\n"
    assert not list(tmp_path.iterdir())


AGENT = """
import numpy as np

class Full:
    def __init__(self, observation_space, action_space, seed): self.shape = action_space.shape
    def act(self, observations): return np.ones((len(observations), *self.shape))
    def learn(self, env, steps): pass
"""


def test_a_missing_library_of_an_agents_module_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "absent_agent.py").write_text("import absent")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [str(tmp_path), *sys.path])
    with pytest.raises(ModuleNotFoundError, match="No module named 'absent'"):
        main(command("absent_agent:make"))


def test_an_agent_of_the_user_is_named_by_module_and_factory(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(AGENT)
    words = [sys.executable, "-m", "gym_extensions", *command("mine:Full", protocol="single")]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=True)
    lines = done.stdout.splitlines()
    assert lines[0] == "5 jobs: 5,000 training steps, 100 evaluation episodes"
    first = "hopper-gravity single-run0-task0 stage 1: gym_extensions/HopperGravityHalf-v0 mean return"
    assert lines[1].startswith(first)
    assert lines[-1] == "The submission is in out. Score it with: score out"
    assert (tmp_path / "out/hopper-gravity/single.csv").exists()


def test_the_printed_command_quotes_the_folder(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    replace_train(monkeypatch, lambda *_, **__: [])
    assert main(command("zero", out="my runs/zero")) == 0
    quoted = '"my runs/zero"' if sys.platform == "win32" else "'my runs/zero'"
    expected = f"The submission is in my runs/zero. Score it with: score {quoted}\n"
    assert capsys.readouterr().out.replace("\\", "/") == expected


def test_after_training_the_runs_that_scoring_misses_are_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    train = command("zero", groups="pusher", protocol="joint", runs="1,3", num_envs="4")
    assert main([*train, "--quiet"]) == 0
    needs = "To be scored, it also needs the runs 0,2: train them, or join the submission that has them"
    assert capsys.readouterr().out == f"The submission is in out. {needs} (gym-extensions merge).\n"
    assert (
        main([*command("zero", groups="pusher", protocol="joint", runs="0,2", num_envs="4"), "--quiet"]) == 0
    )
    assert capsys.readouterr().out == "The submission is in out. Score it with: score out\n"


def test_the_help_names_every_reference_agent(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(algorithms, "names", lambda: ["sac", "trpo"])
    assert "sac, trpo, or module:factory" in " ".join(parser().format_help().split())
