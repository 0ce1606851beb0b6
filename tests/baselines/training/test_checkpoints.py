"""An interrupted run resumes after its last finished stage and ends with the same bytes."""

import json
import os
import subprocess
import sys
import time
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gym_extensions.baselines import Card, Monitor, Observes, train
from gym_extensions.baselines.agent_spec import AgentSpec
from gym_extensions.baselines.isolated.proxy import IsolatedAgent
from gym_extensions.baselines.training.checkpoints import JobFolder
from gym_extensions.baselines.training.jobs import Settings, jobs_of
from gym_extensions.catalog.groups import group
from gym_extensions.catalog.protocol import budget
from gym_extensions.errors import BenchError
from gym_extensions.submissions.run import read_run

from ...conftest import refused
from ..conftest import QUICK_GROUP, SHORT_GROUP, digests

COMMAND = [
    *(sys.executable, "-m", "gym_extensions", "train", "trpo", "--groups", SHORT_GROUP),
    *("--protocol", "sequential,joint", "--budget", "smoke", "--runs", "0", "--out"),
]
MANY_THREADS = {**os.environ, "OPENBLAS_NUM_THREADS": "2"}
"""An environment of the user. The command's worker processes have one thread all the same."""
FIRST_JOB = ".progress/{}/sequential-run0"


def wait_for(path: Path, process: subprocess.Popen[Any]) -> None:
    deadline = time.monotonic() + 600
    while not path.exists() and process.poll() is None and time.monotonic() < deadline:
        time.sleep(0.02)
    assert path.exists()


def is_running(pid: int) -> bool:
    try:
        return "State:\tZ" not in Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return False


def test_a_killed_command_ends_its_workers_and_writes_the_same_files_when_it_is_repeated(
    trpo_submission: Path, tmp_path: Path
) -> None:
    out = tmp_path / "trpo"
    process = subprocess.Popen([*COMMAND, str(out)], stdout=subprocess.DEVNULL, env=MANY_THREADS)
    wait_for(out / FIRST_JOB.format(SHORT_GROUP) / "stage1.json", process)
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
    workers = [int(pid) for pid in children.read_text().split()] if children.exists() else []
    process.kill()
    process.wait()
    if not workers:
        time.sleep(1.0)  # the system does not say when they have ended
    deadline = time.monotonic() + 30
    while (running := [pid for pid in workers if is_running(pid)]) and time.monotonic() < deadline:
        time.sleep(0.02)
    assert not running
    assert not (out / SHORT_GROUP / "sequential").exists()
    done = subprocess.run([*COMMAND, str(out)], check=True, capture_output=True, text=True, env=MANY_THREADS)
    assert "sequential-run0 stage 1:" not in done.stdout, "a finished stage was repeated"
    assert digests(out) == digests(trpo_submission)
    assert not (out / FIRST_JOB.format(SHORT_GROUP)).exists()


class PowerCutError(RuntimeError):
    """The machine stops."""


class Unsaved:
    """An agent without ``save`` that stops once, in stage 2. Its actions depend on the number of stages."""

    has_stopped = False

    def __init__(self, observation_space: Any, action_space: Any, seed: int) -> None:
        self.shape, self.stages = action_space.shape, 0

    def act(self, observations: Any) -> Any:
        return np.full((len(observations), *self.shape), 1.0 - self.stages / 10)

    def learn(self, env: Any, steps: int) -> None:
        self.stages += 1
        if self.stages == 2 and not Unsaved.has_stopped:
            Unsaved.has_stopped = True
            raise PowerCutError


def unfinished(out: Path, agent: Any = None, **options: Any) -> Path:
    """The folder of a job that stopped after two stages, by default of an agent that can be saved."""
    Unsaved.has_stopped = False
    with pytest.raises(PowerCutError):
        train(agent or Saved, QUICK_GROUP, "sequential", "smoke", 0, out=out, **options)
    return out / FIRST_JOB.format(QUICK_GROUP.name)


def test_an_agent_that_cannot_be_saved_starts_again(tmp_path: Path) -> None:
    unfinished(tmp_path / "stopped", Unsaved)
    for name in ("stopped", "complete"):
        (log,) = train(Unsaved, QUICK_GROUP, "sequential", "smoke", 0, out=tmp_path / name)
    assert digests(tmp_path / "stopped") == digests(tmp_path / "complete")
    assert read_run(log.with_suffix(".json")).policies is None, "the agent has none"
    assert not log.with_suffix(".npz").exists()


def test_the_stages_of_an_unfinished_run_with_other_settings_are_not_reused(tmp_path: Path) -> None:
    unfinished(tmp_path, Unsaved)
    for runs, begin in ((0, "The unfinished run has other settings"), ([0, 1], "1 of 2 jobs failed.")):
        with pytest.raises(BenchError) as error:
            train("zero", QUICK_GROUP, "sequential", "smoke", runs, out=tmp_path)
        assert error.value.message.startswith(begin)
        assert ", and 'zero' in this command" in error.value.message


class Saved(Unsaved):
    """The same with ``save``."""

    def save(self, path: Path) -> None:
        path.write_text(str(self.stages))

    def load(self, path: Path) -> None:
        self.stages = {"0": 0, "1": 1}[path.read_text()]


class Renamed(Saved):
    """An agent whose ``save`` writes to another name, as ``numpy.save`` does."""

    def save(self, path: Path) -> None:
        super().save(path.with_name(f"{path.name}.npy"))


class Seeded(Saved):
    """An agent whose hyperparameters contain its seed."""

    def __init__(self, observation_space: Any, action_space: Any, seed: int) -> None:
        super().__init__(observation_space, action_space, seed)
        self.seed = seed

    def card(self) -> Card:
        return Card("Seeded", hyperparameters={"seed": self.seed})


@pytest.mark.parametrize(
    ("agent", "fact"),
    [(Renamed, "save() did not write the file"), (Seeded, "has the hyperparameters {'seed': ")],
)
def test_an_agent_that_could_not_resume_is_refused_at_once(agent: Any, fact: str, tmp_path: Path) -> None:
    with refused("bad-agent", fact):
        train(agent, QUICK_GROUP, "sequential", "smoke", 0, out=tmp_path)
    assert not list(tmp_path.rglob("stage*.json"))


class FolderAgent(Saved):
    """Saves a folder, and its ``load`` is a class method that returns a new agent."""

    def save(self, path: Path) -> None:
        path.mkdir()
        (path / "state.json").write_text(json.dumps({"shape": self.shape, "stages": self.stages}))

    @classmethod
    def load(cls, path: Path) -> Any:
        agent = cls.__new__(cls)
        vars(agent).update(json.loads((path / "state.json").read_text()))
        return agent


def test_a_run_resumes_from_a_folder_with_the_agent_that_load_returns(tmp_path: Path) -> None:
    monitor = Monitor(evaluate_every=500, evaluate_episodes=1)
    folder = unfinished(tmp_path / "stopped", FolderAgent, progress=monitor)
    (folder / ".agent2.partial.npz").mkdir()  # of a stage that was stopped while it was saved
    assert sorted(path.name for path in folder.glob("*agent*")) == [".agent2.partial.npz", "agent1.npz"]
    for name in ("stopped", "complete"):
        train(FolderAgent, QUICK_GROUP, "sequential", "smoke", 0, out=tmp_path / name, progress=monitor)
    assert digests(tmp_path / "stopped") == digests(tmp_path / "complete")


NUMPY = version("numpy")


@pytest.mark.parametrize(
    ("file", "change", "code", "fact"),
    [
        ("agent1.npz", None, "bad-checkpoint", "The agent's checkpoint is missing."),
        ("agent1.npz", ("1", "format 2"), "bad-checkpoint", "KeyError: 'format 2'"),
        ("settings.json", (f'numpy": "{NUMPY}"', 'numpy": "1.0"'), "other-version", "numpy is '1.0'"),
    ],
)
def test_a_checkpoint_that_cannot_be_continued_is_named_and_the_stages_stay(
    file: str, change: tuple[str, str] | None, code: str, fact: str, tmp_path: Path
) -> None:
    path = unfinished(tmp_path) / file
    text = path.read_text()
    path.write_text(text.replace(*change)) if change else path.unlink()
    with refused(code, fact):
        train(Saved, QUICK_GROUP, "sequential", "smoke", 0, out=tmp_path)
    assert sorted(each.name for each in path.parent.glob("stage*")) == ["stage0.json", "stage1.json"]


def test_versions_of_the_agents_packages_belong_to_a_checkpoint(tmp_path: Path) -> None:
    (job,) = jobs_of(group(SHORT_GROUP), "joint", [0])
    spec = AgentSpec("mine", "zero", Card("mine", packages=("pandas",)), Observes())
    folder, settings = JobFolder(tmp_path, job), Settings(spec, budget("smoke"))
    folder.begin(settings)
    folder.begin(settings)
    stored = folder.path / "settings.json"
    stored.write_text(stored.read_text().replace(f'"pandas": "{version("pandas")}"', '"pandas": "1.0"'))
    with pytest.raises(BenchError, match=r"versions\.pandas is '1\.0', and '"):
        folder.begin(settings)


def test_a_run_outside_of_a_box_is_not_continued_in_one_nor_the_reverse(tmp_path: Path) -> None:
    (job,) = jobs_of(group(SHORT_GROUP), "joint", [0])
    outside, inside = (
        Settings(AgentSpec("mine", factory, Card("mine"), Observes()), budget("smoke"))
        for factory in ("zero", IsolatedAgent("zero"))
    )
    for begun, other, fact in (
        (outside, inside, "is False, and True"),
        (inside, outside, "is True, and False"),
    ):
        folder = JobFolder(tmp_path / fact, job)
        folder.begin(begun)
        with refused("other-run-unfinished", f"isolated {fact} in this command"):
            folder.begin(other)


def test_settings_that_do_not_state_a_box_are_those_of_a_run_outside_of_one(tmp_path: Path) -> None:
    folder = unfinished(tmp_path)
    settings = json.loads((folder / "settings.json").read_text())
    del settings["isolated"]
    (folder / "settings.json").write_text(json.dumps(settings))
    train(Saved, QUICK_GROUP, "sequential", "smoke", 0, out=tmp_path)
    assert not folder.exists(), "it was continued"


def test_the_largest_memory_of_a_process_is_not_that_of_the_one_that_started_it() -> None:
    started_by = np.ones(10**8)  # 800 MB
    program = "from gym_extensions.baselines.training import checkpoints; print(checkpoints.peak_memory_mb())"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert 0 <= float(done.stdout) < started_by.nbytes / 1e6
