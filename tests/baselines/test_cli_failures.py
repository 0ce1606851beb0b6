"""The command ``gym-extensions train`` when it is interrupted, or a job, the disk or the agent fails."""

from __future__ import annotations

import errno
from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
import pytest

from gym_extensions.__main__ import main
from gym_extensions.baselines import train_agent
from gym_extensions.baselines.training.events import JobPlan, TrainingStarted

from .train_command import command, replace_train


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
NOT_RUNNING = "No job was running; repeat the same command."
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


def raising(error: BaseException) -> Callable[..., NoReturn]:
    def train(*_: Any, **__: Any) -> NoReturn:
        raise error

    return train


def test_a_full_disk_is_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    replace_train(monkeypatch, raising(OSError(errno.ENOSPC, "No space left on device")))
    assert main(command("trpo", out="mine")) == 2
    message = f"error: mine: No space left on device. Free some disk space. {NOT_RUNNING}\n"
    assert capsys.readouterr().err == message


def test_a_command_that_is_interrupted_before_its_first_job_says_nothing_about_stages(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    replace_train(monkeypatch, raising(KeyboardInterrupt()))
    assert main(command("trpo")) == 130
    assert capsys.readouterr().out == f"Interrupted. {NOT_RUNNING}\n"


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
