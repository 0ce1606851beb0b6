"""The command ``gym-extensions train``: mistakes, output, interruptions, and jobs that fail."""

import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gym_extensions.__main__ import main
from gym_extensions.baselines import train_agent
from gym_extensions.errors import BenchError

OPTIONS = {"--groups": "hopper-gravity", "--budget": "smoke", "--out": "out"}
TWO_JOBS = {"groups": "hopper-motor-noise", "protocol": "single"}


def command(agent: str, **changed: str) -> list[str]:
    """The words of the command with these options added or changed."""
    options = OPTIONS | {f"--{name.replace('_', '-')}": value for name, value in changed.items()}
    return ["train", agent, *(word for pair in options.items() for word in pair)]


MISTAKES = [
    (command("trop"), "'trpo'"),
    (command("trpo", groups="hoper-gravity"), "'hopper-gravity'"),
    (command("trpo", budget="100K"), "'100k'"),
    (command("trpo", runs="1000"), "--runs"),
    (command("trpo", runs="0,4-1"), "1-4"),
    (command("zero", out="zero run"), "'zero run'"),
    (command("trpo", jobs="-1"), "--jobs"),
    (command("trpo", num_envs="0"), "--num-envs"),
    (command("trpo", budget="100k", num_envs="64"), "at most 10"),
    (command("trpo", evaluate_every="500", evaluate_episodes="21"), "at most 20"),
    (command("nowhere:make"), "'nowhere'"),
    (command(".mine:Agent"), "mine:Agent"),
    (command("gym_extensions.baselines.algorithms.trpo:mak"), "'make'"),
]


@pytest.mark.parametrize(("argv", "named"), MISTAKES)
def test_a_mistake_is_reported_in_a_line_before_anything_runs(
    argv: list[str],
    named: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(argv) == 2
    message = capsys.readouterr().err
    assert message.startswith("error: ")
    assert named in message
    assert message.count("\n") == 1
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
    words = [sys.executable, "-m", "gym_extensions", *command("mine:Full", **TWO_JOBS)]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=True)
    lines = done.stdout.splitlines()
    assert lines[0] == "2 jobs: 2,000 training steps"
    first = "hopper-motor-noise single-run0-task0 stage 1: gym_extensions/Hopper"
    assert lines[1].startswith(first)
    assert lines[-1] == "The submission is in out. Score it with: score out"
    assert (tmp_path / "out/hopper-motor-noise/single/run0.csv").exists()


class StopsInSecondTask:
    """Trains on one task, then behaves as if the user pressed Ctrl-C. It can be saved."""

    stops = True

    def __init__(self, observation_space: Any, action_space: Any, seed: int) -> None:
        self.shape, self.calls = action_space.shape, 0

    def act(self, observations: Any) -> Any:
        return np.ones((len(observations), *self.shape))

    def learn(self, env: Any, steps: int) -> None:
        self.calls += 1
        if self.calls == 2 and self.stops:
            raise KeyboardInterrupt

    def save(self, path: Path) -> None:
        path.write_bytes(b"")

    def load(self, path: Path) -> None:
        self.calls = 1


def test_an_interrupted_command_continues_if_the_agent_can_be_saved(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    train = train_agent.train

    def in_this_process(_: str, *positional: Any, **options: Any) -> Any:
        return train(StopsInSecondTask, *positional, **(options | {"jobs": 0}))

    monkeypatch.setattr(train_agent, "train", in_this_process)
    words = command("trpo", groups="hopper-motor-noise", out=str(tmp_path / "mine"))
    assert main(words) == 130
    assert capsys.readouterr().out.splitlines()[-1].startswith("Interrupted. The same command continues")
    monkeypatch.setattr(StopsInSecondTask, "stops", False)
    assert main(words) == 0
    lines = capsys.readouterr().out.splitlines()
    evaluated = {line.partition(":")[0] for line in lines if "mean return" in line and "steps," not in line}
    assert len(evaluated) == 1


SLOW = """
import pathlib, time
from gym_extensions.baselines.algorithms.floors import Zero

class Slow(Zero):
    def learn(self, env, steps):
        pathlib.Path("learns").touch()
        time.sleep(60)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGTERM")
@pytest.mark.parametrize("jobs", ["0", "1"])
def test_a_command_that_a_scheduler_ends_says_that_it_continues(jobs: str, tmp_path: Path) -> None:
    (tmp_path / "slow.py").write_text(SLOW)
    words = [sys.executable, "-m", "gym_extensions", *command("slow:Slow", protocol="joint", jobs=jobs)]
    with subprocess.Popen(words, cwd=tmp_path, stdout=subprocess.PIPE, text=True) as process:
        while not (tmp_path / "learns").exists():
            time.sleep(0.05)
        process.terminate()
        printed, _ = process.communicate(timeout=30)
    assert process.returncode == 128 + signal.SIGTERM
    assert printed.splitlines()[-1].startswith("Interrupted. The same command continues")


FAILING = """
import numpy as np
import os, signal

class Fails:
    def __init__(self, observation_space, action_space, seed): self.shape = action_space.shape
    def act(self, observations): return np.ones((len(observations), *self.shape))
    def learn(self, env, steps): raise ValueError("no gradient")

class Dies(Fails):
    def learn(self, env, steps): os.kill(os.getpid(), signal.SIGKILL)

class Exits(Fails):
    def learn(self, env, steps): os._exit(3)

class Interrupts(Fails):
    def learn(self, env, steps): raise KeyboardInterrupt

class Mute(Exception):
    def __str__(self): raise RuntimeError

class Stutters(Fails):
    def learn(self, env, steps): raise Mute

class FailsOnce(Fails):
    def learn(self, env, steps):
        try: os.mkdir("failed")
        except FileExistsError: return
        raise ValueError("no gradient")
"""
DIED = "The worker process was ended by SIGKILL. If memory ran out, use fewer --jobs or --num-envs."
CAUSES = {
    "Fails": "ValueError: no gradient",
    "Interrupts": "KeyboardInterrupt",
    "Stutters": "Mute",
    "Dies": DIED,
    "Exits": "The worker process ended with status 3 before its job did; it printed why.",
}
TRACEBACKS = "Tracebacks are in mine/.progress/train.log."
SHORT = {"groups": "hopper-motor-noise", "protocol": "joint"}


class Quits(StopsInSecondTask):
    def learn(self, env: Any, steps: int) -> None:
        sys.exit(0)


def test_an_agent_that_exits_does_not_end_the_process_that_trains_it(tmp_path: Path) -> None:
    with pytest.raises(BenchError, match="joint-run0: SystemExit: 0"):
        train_agent.train(Quits, SHORT["groups"], "joint", "smoke", 0, out=tmp_path / "mine")


@pytest.mark.parametrize(("name", "cause"), CAUSES.items())
def test_a_failed_job_is_reported_with_its_cause(
    name: str, cause: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "failing.py").write_text(FAILING)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    assert main(command(f"failing:{name}", out="mine", **SHORT)) == 1
    printed = capsys.readouterr()
    assert f"hopper-motor-noise joint-run0: failed: {cause}\n" in printed.out
    failed = f"error: 1 of 1 job failed.\n  hopper-motor-noise joint-run0: {cause}\n"
    assert printed.err.startswith(f"{failed}{TRACEBACKS}")
    log = Path("mine/.progress/train.log").read_text()
    assert ("Traceback (most recent call last)" in log) == (name not in ("Dies", "Exits"))


def test_a_failed_job_stops_no_other_and_is_repeated_by_the_same_command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "failing.py").write_text(FAILING)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    words = command("failing:FailsOnce", out="mine", runs="0-2", **SHORT)

    def runs() -> set[str]:
        return {path.stem for path in Path("mine/hopper-motor-noise/joint").glob("*.csv")}

    assert main(words) == 1
    assert capsys.readouterr().err.startswith(
        "error: 1 of 3 jobs failed.\n  hopper-motor-noise joint-run0: Val"
    )
    assert runs() == {"run1", "run2"}
    assert main(words) == 0
    assert runs() == {"run0", "run1", "run2"}
