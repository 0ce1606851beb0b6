"""Frozen floors and experts that normalize returns: 0 ignores observations, 1 is the task's expert.

``<version>.json`` beside this module has those of a benchmark version, which ``tools.references`` writes;
``maintain references`` measures those of custom groups.
"""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Literal

import msgspec

from gym_extensions.catalog.protocol import STANDARD_BUDGET
from gym_extensions.errors import BenchError

CURRENT = "2"
"""The benchmark version whose references normalize every score."""
ALONE, ALONE_VERSION = "alone", "1"
"""The row *each task alone* of boards, and the version of the references that has its runs: there, the score
1 is the reference agent after 300,000 steps on the task alone, in navigation the planner."""


class FloorAgent(msgspec.Struct, omit_defaults=True):
    """Returns of an agent that ignores observations: mean, population standard deviation, and its seed."""

    mean: float
    std: float = 0.0
    standard_error: float = 0.0
    seed: int = 0


class Floor(msgspec.Struct, omit_defaults=True):
    """The better one of two agents that ignore observations, over ``episodes`` prescribed episodes each."""

    mean: float
    agent: str = ""
    episodes: int = 0
    standard_error: float = 0.0
    agents: dict[str, FloorAgent] = {}
    fingerprint: str = ""


class MeasuredRun(msgspec.Struct, omit_defaults=True):
    """The mean return of one training run; in version 1 with more."""

    run: int
    mean: float
    std: float = 0.0
    beats_floor: bool = True


class Expert(msgspec.Struct, omit_defaults=True):
    """What the score 1 stands for.

    Args:
        standard_error: of the mean, over the runs if there are several, else over the episodes.
        episodes: number of episodes (of each run).
        agent: who acts: ``expert``, a published policy with its SHA-256; ``planner``; or the agent of runs.
        provisional: why it does not do what the task is for.
    """

    mean: float
    standard_error: float = 0.0
    episodes: int = 0
    agent: str = ""
    policy: str = ""
    provisional: str = ""
    budget: str = ""
    runs: list[MeasuredRun] = []

    @property
    def df(self) -> float:
        """Degrees of freedom of the standard error."""
        return float(max((len(self.runs) if len(self.runs) > 1 else self.episodes) - 1, 0))


class Reference(msgspec.Struct):
    """A task's floor and expert in raw returns; an *open* task has no expert.

    The ``attempts`` of an open task did not beat the floor clearly.
    """

    floor: Floor
    expert: Expert | None
    attempts: Expert | msgspec.UnsetType | None = msgspec.UNSET

    @property
    def open(self) -> bool:
        """Whether no expert is known that is clearly better than the floor."""
        return self.expert is None

    @property
    def expert_error(self) -> tuple[float, float]:
        """The expert's standard error in spans from floor to expert, and its df; both 0 for an open task."""
        if self.expert is None:
            return 0.0, 0.0
        return self.expert.standard_error / (self.expert.mean - self.floor.mean), self.expert.df

    def normalize(self, value: float) -> float:
        """(value − floor) / (expert − floor), not clipped. Raises ValueError for an open task."""
        if self.expert is None:
            raise ValueError("An open task has no normalized return.")
        return (value - self.floor.mean) / (self.expert.mean - self.floor.mean)


class File(msgspec.Struct):
    """A references file."""

    format: Literal[2]
    version: str
    tasks: dict[str, Reference]


@dataclass(frozen=True, repr=False)
class References:
    """The references of one benchmark version by task id. ``digest`` is the SHA-256 of their file."""

    version: str
    tasks: Mapping[str, Reference]
    digest: str = ""

    def __repr__(self) -> str:
        return f"References({self.version!r}, {len(self.tasks)} tasks)"

    def missing(self, task_ids: Sequence[str]) -> list[str]:
        """The tasks without a reference."""
        return [task for task in task_ids if task not in self.tasks]


def parse_references(data: bytes) -> References:
    """The references of a JSON file (docs/metrics.md).

    Raises:
        ValueError: the format is another one, a standard error is not one, or an expert is not above the
            floor.
    """
    document = msgspec.json.decode(data, type=File)
    for name, task in document.tasks.items():
        expert, floor = task.expert, task.floor.mean
        if expert is None:
            continue
        if expert.standard_error < 0 or (expert.standard_error > 0 and expert.df < 1):
            error = f"standard error {expert.standard_error} with {expert.df} degrees of freedom"
            raise ValueError(f"{name}: {error}")
        if expert.mean <= floor:
            raise ValueError(f"{name}: the expert, {expert.mean}, is not above the floor, {floor}")
    return References(document.version, document.tasks, hashlib.sha256(data).hexdigest())


def add_references(published: References, own: References) -> References:
    """The published references and a user's own for further tasks.

    A published reference is never replaced. The version and the digest name both files.
    """
    return References(
        version=f"{published.version} + {own.version}",
        tasks={**own.tasks, **published.tasks},
        digest=hashlib.sha256(f"{published.digest} {own.digest}".encode()).hexdigest(),
    )


def read_references(path: Path) -> References:
    """The references of a file of ``maintain references``. Raises ``BenchError`` for another file."""
    try:
        return parse_references(path.read_bytes())
    except OSError as error:
        raise BenchError("unreadable-references", f"{error.strerror or error}.", str(path)) from error
    except (ValueError, RecursionError) as error:
        message = f"The file does not hold references: {str(error).rstrip('.')}."
        hint = "Write it with: gym-extensions maintain references."
        raise BenchError("malformed-references", message, str(path), hint) from error


def path_of(version: str = CURRENT) -> Path:
    """The file of a benchmark version."""
    return Path(__file__).with_name(f"{version}.json")


def load_references(version: str = CURRENT) -> References:
    """The references of a benchmark version."""
    return read_references(path_of(version))


@cache
def trained_alone() -> Mapping[str, Expert]:
    """The reference agent after 300,000 steps on a task alone: the runs of version 1, by task id."""
    tasks = read_references(path_of(ALONE_VERSION)).tasks
    found = {name: task.expert or task.attempts or None for name, task in tasks.items()}
    return {name: each for name, each in found.items() if each and each.budget == STANDARD_BUDGET}
