"""Small submissions that several tests read. Tests that change one copy it first."""

import csv
import hashlib
import json
from pathlib import Path
from typing import NamedTuple

import pytest

from gym_extensions.baselines import Monitor, references, train, workers
from gym_extensions.baselines.training.progress import Event
from gym_extensions.envs import MovingGoal, TaskGroup, customize

SHORT_GROUP = "pusher"
"""A published group of two tasks with episodes of 100 steps."""
QUICK_GROUP = TaskGroup(
    "quick-pusher", (customize("Pusher", max_steps=10), customize("Pusher", [MovingGoal()], max_steps=10))
)
"""The same with episodes of 10 steps, for tests that need no published group."""
QUICK_TOML = """
name = "quick-pusher"
[[tasks]]
task = "Pusher"
max_steps = 10
[[tasks]]
task = "Pusher"
variations = [{kind = "MovingGoal"}]
max_steps = 10
"""


MEASURED = ("command", "commit", "date", "machine", "cpu_seconds", "peak_memory_mb")
"""Keys of a run's document that differ between two equal runs."""


def digests(folder: Path) -> dict[str, str]:
    """The sha256 of every finished file, by its path in the folder; of documents without what is measured."""
    return {
        path.relative_to(folder).as_posix(): hashlib.sha256(_content(path)).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and ".progress" not in path.parts
    }


def _content(path: Path) -> bytes:
    if path.suffix != ".json":
        return path.read_bytes()
    document = json.loads(path.read_bytes())
    return json.dumps({key: value for key, value in document.items() if key not in MEASURED}).encode()


def log_rows(path: Path) -> list[dict[str, str]]:
    """The rows of a log."""
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


@pytest.fixture(scope="session")
def quick_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The TOML file of ``QUICK_GROUP``."""
    path = tmp_path_factory.mktemp("groups") / "quick.toml"
    path.write_text(QUICK_TOML, encoding="utf-8")
    return path


@pytest.fixture(scope="session")
def trpo_submission(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """trpo, sequential and joint, run 0, at the smoke budget."""
    folder = tmp_path_factory.mktemp("submissions") / "trpo"
    train("trpo", SHORT_GROUP, ["sequential", "joint"], "smoke", 0, out=folder)
    return folder


@pytest.fixture(scope="session")
def random_submission(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """random, single, run 0, at the smoke budget."""
    folder = tmp_path_factory.mktemp("submissions") / "random"
    train("random", "hopper-motor-noise", "single", "smoke", 0, out=folder)
    return folder


class Watched(NamedTuple):
    """A submission, and the events of its training."""

    folder: Path
    events: list[Event]


@pytest.fixture(scope="session")
def watched(tmp_path_factory: pytest.TempPathFactory) -> Watched:
    """The training of ``trpo_submission`` again, with evaluation during training."""
    seen = Watched(tmp_path_factory.mktemp("watched") / "trpo", [])
    monitor = Monitor(callback=seen.events.append, evaluate_every=500, evaluate_episodes=2)
    train("trpo", SHORT_GROUP, ["sequential", "joint"], "smoke", 0, out=seen.folder, progress=monitor)
    return seen


def make_quick(patch: pytest.MonkeyPatch, episodes: int) -> None:
    """Measures floors with this many episodes, in this process."""
    measurements, run = references.floor_measurements, workers.run
    patch.setattr(references, "floor_measurements", lambda task, _=None: measurements(task, episodes))
    patch.setattr(workers, "run", lambda pending, listen, jobs: run(pending, listen, 0))


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    make_quick(monkeypatch, 4)
