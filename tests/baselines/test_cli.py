"""The command ``gym-extensions train``: its error messages and its output."""

from __future__ import annotations

import errno
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
import pytest

from gym_extensions.__main__ import main
from gym_extensions.baselines import algorithms, train_agent
from gym_extensions.baselines.cli import parser
from gym_extensions.baselines.training.events import JobPlan, TrainingStarted

OPTIONS = {"--groups": "hopper-gravity", "--budget": "smoke", "--out": "out"}


def command(agent: str, **changed: str) -> list[str]:
    options = OPTIONS | {f"--{name.replace('_', '-')}": value for name, value in changed.items()}
    return ["train", agent, *(word for pair in options.items() for word in pair)]


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


def replace_train(monkeypatch: pytest.MonkeyPatch, function: Callable[..., Any]) -> None:
    monkeypatch.setattr(train_agent, "train", function)


def test_the_printed_command_quotes_the_folder(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    replace_train(monkeypatch, lambda *_, **__: [])
    assert main(command("zero", out="my runs/zero")) == 0
    quoted = '"my runs/zero"' if sys.platform == "win32" else "'my runs/zero'"
    expected = f"The submission is in my runs/zero. Score it with: score {quoted}\n"
    assert capsys.readouterr().out.replace("\\", "/") == expected


def test_the_help_names_every_reference_agent(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(algorithms, "names", lambda: ["sac", "trpo"])
    assert "sac, trpo, or module:factory" in " ".join(parser().format_help().split())


class StopsInSecondTask:
    """Trains on one task, then behaves as if the user pressed Ctrl-C."""

    def __init__(self, observation_space: Any, action_space: Any, seed: int) -> None:
        self.shape, self.calls = action_space.shape, 0

    def act(self, observations: Any) -> Any:
        return np.ones((len(observations), *self.shape))

    def learn(self, env: Any, steps: int) -> None:
        self.calls += 1
        if self.calls == 2:
            raise KeyboardInterrupt


class StopsAndCanBeSaved(StopsInSecondTask):
    def save(self, path: Path) -> None:
        path.write_bytes(b"")

    def load(self, path: Path) -> None:
        self.calls = 1


AGAIN = "No finished stage can be reused; the same command starts the unfinished runs again."
INTERRUPTED: list[tuple[Any, str]] = [
    (StopsAndCanBeSaved, "The same command continues; it reuses 2 finished stages."),
    (StopsInSecondTask, AGAIN),
]


@pytest.mark.parametrize(("agent", "expected"), INTERRUPTED)
def test_an_interrupted_command_says_whether_it_can_be_continued(
    agent: Any,
    expected: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    train = train_agent.train

    def in_this_process(_: str, *positional: Any, **options: Any) -> Any:
        return train(agent, *positional, **(options | {"jobs": 0}))

    replace_train(monkeypatch, in_this_process)
    assert main(command("trpo", groups="hopper-motor-noise", out=str(tmp_path / "mine"))) == 130
    assert capsys.readouterr().out.splitlines()[-1] == f"Interrupted. {expected}"


def test_stages_of_other_runs_are_not_counted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "mine/.progress/hopper-gravity/sequential-run3"
    folder.mkdir(parents=True)
    (folder / "settings.json").write_text('{"stages": 6}')
    for name in ("stage0.json", "agent0.npz"):
        (folder / name).touch()

    def interrupted(*_: Any, callback: Callable[[TrainingStarted], None], **__: Any) -> NoReturn:
        callback(TrainingStarted(tuple(JobPlan(f"hopper-gravity sequential-run{run}", ()) for run in runs)))
        raise KeyboardInterrupt

    replace_train(monkeypatch, interrupted)
    runs = [0]
    assert main(command("trpo", out=str(tmp_path / "mine"))) == 130
    assert capsys.readouterr().out.splitlines()[-1] == f"Interrupted. {AGAIN}"
    runs = [0, 3]
    assert main(command("trpo", out=str(tmp_path / "mine"))) == 130
    expected = "Interrupted. The same command continues; it reuses 1 finished stage."
    assert capsys.readouterr().out.splitlines()[-1] == expected


def raising(error: Exception) -> Callable[..., NoReturn]:
    def train(*_: Any, **__: Any) -> NoReturn:
        raise error

    return train


def test_a_full_disk_is_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    replace_train(monkeypatch, raising(OSError(errno.ENOSPC, "No space left on device")))
    assert main(command("trpo", out="mine")) == 2
    message = f"error: mine: No space left on device. Free some disk space. {AGAIN}\n"
    assert capsys.readouterr().err == message


FAILING = """
import numpy as np
import os, signal

class Fails:
    def __init__(self, observation_space, action_space, seed): self.shape = action_space.shape
    def act(self, observations): return np.ones((len(observations), *self.shape))
    def learn(self, env, steps): raise ValueError("no gradient")

class Dies(Fails):
    def learn(self, env, steps): os.kill(os.getpid(), signal.SIGKILL)

class FailsOnce(Fails):
    def learn(self, env, steps):
        try: os.mkdir("failed")
        except FileExistsError: return
        raise ValueError("no gradient")
"""
DIED = "The worker process ended unexpectedly. If memory ran out, use fewer --jobs or --num-envs."
TRACEBACKS = "Tracebacks are in mine/.progress/train.log."
SHORT = {"groups": "hopper-motor-noise", "protocol": "joint"}


@pytest.mark.parametrize(("name", "cause"), [("Fails", "ValueError: no gradient"), ("Dies", DIED)])
def test_a_failed_job_is_reported_with_its_cause(
    name: str, cause: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "failing.py").write_text(FAILING)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    assert main(command(f"failing:{name}", out="mine", **SHORT)) == 1
    printed = capsys.readouterr()
    assert f"hopper-motor-noise joint-run0: failed: {cause}\n" in printed.out
    assert printed.err == (
        f"error: 1 of 1 job failed.\n  hopper-motor-noise joint-run0: {cause}\n{TRACEBACKS} {AGAIN}\n"
    )
    log = Path("mine/.progress/train.log").read_text()
    assert ("Traceback (most recent call last)" in log) == (name == "Fails")


def test_a_failed_job_stops_no_other_and_is_repeated_by_the_same_command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "failing.py").write_text(FAILING)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    words = command("failing:FailsOnce", out="mine", runs="0-2", **SHORT)
    log = Path("mine/hopper-motor-noise/joint.csv")

    def runs() -> set[str]:
        return {line.partition(",")[0] for line in log.read_text().splitlines()[1:]}

    assert main(words) == 1
    assert capsys.readouterr().err.startswith(
        "error: 1 of 3 jobs failed.\n  hopper-motor-noise joint-run0: Val"
    )
    assert runs() == {"1", "2"}
    assert main(words) == 0
    assert runs() == {"0", "1", "2"}


def test_a_missing_file_of_the_agent_is_raised_unchanged(monkeypatch: pytest.MonkeyPatch) -> None:
    error = FileNotFoundError(errno.ENOENT, "No such file or directory", "weights.npz")
    replace_train(monkeypatch, raising(error))
    with pytest.raises(FileNotFoundError, match=r"weights\.npz"):
        main(command("trpo"))


def test_a_missing_extra_is_named_with_the_command_that_installs_it(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    replace_train(monkeypatch, raising(ModuleNotFoundError("No module named 'torch'", name="torch")))
    assert main(command("mine:make_ppo")) == 2
    expected = "error: The agent needs torch. Install it with: pip install 'gym-extensions[sb3]'\n"
    assert capsys.readouterr().err == expected
