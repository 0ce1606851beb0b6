"""The command: what it refuses, word for word, and what it prints."""

from __future__ import annotations

import errno
import subprocess
import sys

import pytest

from gym_extensions.__main__ import main
from gym_extensions.baselines import algorithms
from gym_extensions.baselines.cli import numbers, parser
from gym_extensions.errors import BenchError

GOOD = {"--group": "hopper-gravity", "--budget": "smoke", "--out": "out"}


def words(agent: str, **changed: str) -> list[str]:
    options = GOOD | {f"--{name}": value for name, value in changed.items()}
    return ["train", agent, *(word for pair in options.items() for word in pair)]


ALL_AGENTS = "An agent of your own is named as module:factory."
MISTAKES = [
    (
        words("trop"),
        f"There is no agent 'trop'. Did you mean 'trpo'? {ALL_AGENTS}",
    ),
    (
        words("trpo", group="hoper-gravity"),
        "There is no group 'hoper-gravity'. Did you mean 'hopper-gravity'?",
    ),
    (
        words("trpo", budget="100K"),
        "There is no budget '100K'. Did you mean '100k'?",
    ),
    (
        words("trpo", protocol="serial"),
        "There is no protocol 'serial'. Did you mean 'sequential'?",
    ),
    (
        words("trpo", runs="1000"),
        "--runs: 1000 is no run of a submission. Give numbers from 0 to 999; those above are for references.",
    ),
    (
        words("trpo", runs="a"),
        "--runs: 'a' is no list of runs. Give numbers and ranges, as in 0,1 or 0-4.",
    ),
    (
        words("trpo", runs="0,4-1"),
        "--runs: The range '4-1' is empty. Write the smaller number first, as in 1-4.",
    ),
    (
        words("still", out="still run"),
        "still run: 'still run' is no name of a submission. "
        "Begin with a letter or digit; then letters, digits, dots, dashes, underscores, 64 in all.",
    ),
    (
        words("trpo", jobs="0"),
        "--jobs: 0 processes are too few. Give at least 1.",
    ),
    (
        words("trpo", lanes="0"),
        "--lanes: 0 training lanes are too few. Give at least 1.",
    ),
    (
        words("trpo", budget="100k", lanes="64"),
        "--lanes: 64 lanes leave fewer than 10 episodes a lane in budget '100k'. "
        "Give at most 10 for hopper-gravity.",
    ),
    (
        words("nowhere:make"),
        "There is no module 'nowhere'. Run from the folder that holds it, or install it.",
    ),
    (
        words("gym_extensions.baselines.algorithms.trpo:mak"),
        "Module 'gym_extensions.baselines.algorithms.trpo' has nothing callable named 'mak'. "
        "Did you mean 'make'?",
    ),
    (
        ["reference", "--groups", "hopper-gravity", "--budget", "smoke", "--runs", "3", "--out", "x.json"],
        "--runs: 3 is no reference run. Give numbers from 1000 on; those below are for submissions.",
    ),
]


@pytest.mark.parametrize(("argv", "message"), MISTAKES, ids=[row[1][:40] for row in MISTAKES])
def test_a_mistake_is_told_in_a_sentence_before_anything_is_run(argv, message, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(argv) == 2
    assert capsys.readouterr().err == f"error: {message}\n"
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("text", "expected"), [("0", [0]), ("0,1", [0, 1]), ("0-4", [0, 1, 2, 3, 4]), ("7, 2-3", [7, 2, 3])]
)
def test_runs_are_numbers_and_ranges(text, expected):
    assert numbers(text) == expected


@pytest.mark.parametrize("text", ["", "-1", "1-", "0;1", "1.5"])
def test_anything_else_is_no_list_of_runs(text):
    with pytest.raises(BenchError, match="is no list of runs"):
        numbers(text)


def test_an_agent_of_ones_own_is_named_by_module_and_factory(tmp_path):
    (tmp_path / "mine.py").write_text(
        "import numpy as np\n"
        "class Full:\n"
        "    def __init__(self, observation_space, action_space, seed): self.shape = action_space.shape\n"
        "    def act(self, observations): return np.ones((len(observations), *self.shape))\n"
        "    def learn(self, env, steps): pass\n"
    )
    command = [sys.executable, "-m", "gym_extensions", *words("mine:Full", protocol="single")]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
    lines = done.stdout.splitlines()
    assert lines[0] == "5 units to run, 5 cells to evaluate"
    assert lines[1].startswith(
        "hopper-gravity single-run0-task0 stage 1: gym_extensions/HopperGravityHalf-v0 mean"
    )
    assert lines[-1] == "The submission is in out. Look at it with: score out"
    assert (tmp_path / "out/hopper-gravity/single.csv").exists()


def test_the_printed_line_can_be_pasted_whatever_the_folder_above_is_called(tmp_path, monkeypatch, capsys):
    from gym_extensions.baselines import train

    monkeypatch.setattr(train, "train", lambda *_, **__: [])
    assert main(words("still", out="my runs/still")) == 0
    expected = "The submission is in my runs/still. Look at it with: score 'my runs/still'\n"
    assert capsys.readouterr().out == expected


def test_the_help_names_every_reference_agent(monkeypatch):
    monkeypatch.setattr(algorithms, "names", lambda: ["sac", "trpo"])
    assert "sac, trpo, or module:factory of your own" in " ".join(parser().format_help().split())


def test_a_stopped_command_says_how_to_go_on(tmp_path, monkeypatch, capsys):
    from gym_extensions.baselines import train

    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(train, "train", interrupted)
    assert main([*words("trpo")[:-1], str(tmp_path)]) == 130
    assert capsys.readouterr().out == "Stopped. The same command goes on from the last finished stage.\n"


def test_a_full_disk_is_told_and_how_to_go_on(tmp_path, monkeypatch, capsys):
    from gym_extensions.baselines import train

    def full(*_, **__):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(train, "train", full)
    assert main(words("trpo", out="mine")) == 2
    assert capsys.readouterr().err == (
        "error: mine: No space left on device. "
        "Make room; the same command goes on from the last finished stage.\n"
    )


def test_a_file_that_an_agent_of_ones_own_misses_keeps_its_own_words(monkeypatch):
    from gym_extensions.baselines import train

    def missing(*_, **__):
        raise FileNotFoundError(errno.ENOENT, "No such file or directory", "weights.npz")

    monkeypatch.setattr(train, "train", missing)
    with pytest.raises(FileNotFoundError, match=r"weights\.npz"):
        main(words("trpo"))


def test_training_without_the_extra_says_what_to_install(tmp_path, monkeypatch, capsys):
    from gym_extensions.baselines import train

    def missing(*_, **__):
        raise ModuleNotFoundError("No module named 'torch'", name="torch")

    monkeypatch.setattr(train, "train", missing)
    assert main([*words("trpo")[:-1], str(tmp_path)]) == 2
    expected = (
        "error: Training needs torch. Install the extra: pip install -c constraints.txt '.[baselines]'\n"
    )
    assert capsys.readouterr().err == expected
