"""The command ``gym-extensions train``: mistakes, output, interruptions, and jobs that fail."""

import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

from gym_extensions.__main__ import main
from gym_extensions.baselines import algorithms, train_agent
from gym_extensions.baselines.algorithms.floors import Zero
from gym_extensions.errors import BenchError

from ..conftest import refused

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
    (command("trpo", runs="0-9999999999"), "is not a list of runs"),
    (command("zero", out="zero run"), "'zero run'"),
    (command("trpo", jobs="-1"), "--jobs: jobs is -1. Give a whole number from 0."),
    (command("trpo", num_envs="0"), "--num-envs"),
    (command("trpo", budget="100k", num_envs="64"), "at most 10"),
    (command("trpo", evaluate_every="500", evaluate_episodes="21"), "at most 20"),
    (command("nowhere:make"), "'nowhere'"),
    (command(".mine:Agent"), "mine:Agent"),
    (command("trpo", num_envs="64"), "at most 20"),
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


@pytest.mark.parametrize(("name", "hint"), [("my-agent.py", "letters"), ("json.py", "Rename the file")])
def test_a_file_whose_name_cannot_be_that_of_its_module_is_refused(
    name: str, hint: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "path", sys.path.copy())
    (tmp_path / name).write_text(AGENT)
    with refused("unknown-agent", hint):
        algorithms.factory(f"{tmp_path / name}:Full")


AGENT = "from gym_extensions.baselines.algorithms.floors import Zero\nclass Full(Zero): pass"


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


SLOW = """
import pathlib, time
from gym_extensions.baselines.algorithms.floors import Zero

class Slow(Zero):
    def learn(self, env, steps):
        pathlib.Path("learns").touch()
        time.sleep(60)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGTERM")
@pytest.mark.parametrize(
    ("jobs", "sent"), [("0", signal.SIGTERM), ("1", signal.SIGTERM), ("0", signal.SIGINT)]
)
def test_an_interrupted_command_says_how_to_continue(jobs: str, sent: signal.Signals, tmp_path: Path) -> None:
    (tmp_path / "slow.py").write_text(SLOW)
    words = [sys.executable, "-m", "gym_extensions", *command("slow:Slow", protocol="joint", jobs=jobs)]
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background jobs inherit SIG_IGN
    with subprocess.Popen(words, cwd=tmp_path, stdout=subprocess.PIPE, text=True) as process:
        while not (tmp_path / "learns").exists():
            time.sleep(0.05)
        process.send_signal(sent)
        printed, _ = process.communicate(timeout=30)
    assert process.returncode == 128 + sent
    assert printed.splitlines()[-1].startswith("Interrupted. The same command continues")


def test_a_second_signal_does_not_interrupt_what_follows_the_first(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ended = []

    def interrupted(*_: Any, **__: Any) -> None:
        try:
            signal.raise_signal(signal.SIGTERM)
        finally:
            signal.raise_signal(signal.SIGTERM)
            ended.append("in order")

    monkeypatch.setattr("gym_extensions.baselines.train", interrupted)
    assert main(command("trpo", out=str(tmp_path / "mine"))) == 128 + signal.SIGTERM
    assert ended == ["in order"]


def test_an_interrupt_while_the_simulator_is_loaded_has_the_same_exit_status(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def interrupted(name: str) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("gym_extensions.baselines.__getattr__", interrupted)
    assert main(command("trpo")) == 128 + signal.SIGINT


FAILING = """
import os, signal
from gym_extensions.baselines.algorithms.floors import Zero

class Fails(Zero):
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


class Quits(Zero):
    def learn(self, env: Any, steps: int) -> None:
        sys.exit(0)


def test_an_agent_that_exits_does_not_end_the_process_that_trains_it(tmp_path: Path) -> None:
    with pytest.raises(BenchError, match="joint-run0: SystemExit: 0"):
        train_agent.train(Quits, SHORT["groups"], "joint", "smoke", 0, out=tmp_path / "mine")


@pytest.fixture
def failing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The current folder has a module of these agents."""
    (tmp_path / "failing.py").write_text(FAILING)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)


@pytest.mark.usefixtures("failing")
@pytest.mark.parametrize(("name", "cause"), CAUSES.items())
def test_a_failed_job_is_named_with_cause(name: str, cause: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(command(f"failing:{name}", out="mine", **SHORT)) == 1
    printed = capsys.readouterr()
    assert f"hopper-motor-noise joint-run0: failed: {cause}\n" in printed.out
    failed = f"error: 1 of 1 job failed.\n  hopper-motor-noise joint-run0: {cause}\n"
    assert printed.err.startswith(f"{failed}{TRACEBACKS}")
    log = Path("mine/.progress/train.log").read_text()
    assert ("Traceback (most recent call last)" in log) == (name not in ("Dies", "Exits"))


@pytest.mark.usefixtures("failing")
def test_a_failed_job_stops_no_other_and_the_command_repeats_it(capsys: pytest.CaptureFixture[str]) -> None:
    words = command("failing:FailsOnce", out="mine", runs="0-2", **SHORT)

    def runs() -> set[str]:
        return {path.stem for path in Path("mine/hopper-motor-noise/joint").glob("*.csv")}

    assert main(words) == 1
    assert "1 of 3 jobs failed.\n  hopper-motor-noise joint-run0: Val" in capsys.readouterr().err
    assert runs() == {"run1", "run2"}
    assert main(words) == 0
    assert runs() == {"run0", "run1", "run2"}
