"""Frozen floors and ceilings that normalize returns. 0 ignores observations, 1 is the reference agent."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import msgspec

from gym_extensions.errors import BenchError

REFERENCES = Path(__file__).parent / "references_data"
CURRENT = "1"
"""The benchmark version whose references normalize every score."""


@dataclass(frozen=True)
class Reference:
    """A task's floor and ceiling in raw returns; a task that no agent has learned has no ceiling.

    Attributes:
        floor: the higher mean return of the two agents that ignore observations.
        ceiling: the mean return of the reference agent; None if unsolved.
        unsolved: whether the reference agent did not learn the task.
        agents: the mean return of both agents of the floor, ``random`` and ``zero``; empty if not known.

    Raises:
        ValueError: a number is not finite, a solved task has no ceiling above its floor, or an unsolved one
            has a ceiling.
    """

    floor: float
    ceiling: float | None
    unsolved: bool
    agents: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        numbers = (self.floor, *self.agents.values(), *(() if self.ceiling is None else (self.ceiling,)))
        if not all(map(math.isfinite, numbers)):
            raise ValueError(f"a return is not finite: {self}")
        if self.unsolved and self.ceiling is not None:
            raise ValueError(f"it is unsolved and has a ceiling of {self.ceiling}")
        if not self.unsolved and (self.ceiling is None or self.ceiling <= self.floor):
            raise ValueError(f"the ceiling, {self.ceiling}, is not above the floor, {self.floor}")

    def normalize(self, value: float) -> float:
        """(value − floor) / (ceiling − floor), not clipped. Raises ValueError for an unsolved task."""
        return self.normalize_all([value])[0]

    def normalize_all(self, values: Iterable[float]) -> list[float]:
        """Every value normalized. Raises ValueError for an unsolved task."""
        if self.ceiling is None:
            raise ValueError("An unsolved task has no normalized return.")
        floor, span = self.floor, self.ceiling - self.floor
        return [(value - floor) / span for value in values]


@dataclass(frozen=True)
class References:
    """The references of one benchmark version by task id. ``digest`` is the SHA-256 of their file."""

    version: str
    tasks: Mapping[str, Reference]
    digest: str = ""

    def missing(self, task_ids: Sequence[str]) -> list[str]:
        """The tasks without a reference."""
        return [task for task in task_ids if task not in self.tasks]


class _Mean(msgspec.Struct):
    mean: float


class _Floor(_Mean):
    agents: dict[str, _Mean] = {}


class _Task(msgspec.Struct):
    floor: _Floor
    unsolved: bool = False
    ceiling: _Mean | msgspec.UnsetType | None = msgspec.UNSET


class _File(msgspec.Struct):
    format: Literal[1]
    version: str
    tasks: dict[str, _Task]


def parse_references(data: bytes) -> References:
    """The references of a JSON file of format 1 (docs/metrics.md). Tasks without a key ``ceiling`` are left
    out: their reference runs are not measured yet.

    Raises:
        ValueError: another format, or a task's numbers are not those of a reference; the text says which.
    """
    document = msgspec.json.decode(data, type=_File)
    tasks = {}
    for name, task in document.tasks.items():
        if task.ceiling is msgspec.UNSET:
            continue
        ceiling = None if task.ceiling is None else task.ceiling.mean
        agents = {agent: value.mean for agent, value in task.floor.agents.items()}
        try:
            tasks[name] = Reference(task.floor.mean, ceiling, task.unsolved, agents)
        except ValueError as error:
            raise ValueError(f"{name}: {error}") from error
    return References(document.version, tasks, hashlib.sha256(data).hexdigest())


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
    """The references of a file that ``gym-extensions maintain references`` wrote.

    Raises:
        BenchError: the file cannot be read or does not hold references.
    """
    try:
        return parse_references(path.read_bytes())
    except OSError as error:
        raise BenchError("unreadable-references", f"{error.strerror or error}.", str(path)) from error
    except (ValueError, RecursionError) as error:
        message = f"The file does not hold references: {str(error).rstrip('.')}."
        hint = "Write it with: gym-extensions maintain references."
        raise BenchError("malformed-references", message, str(path), hint) from error


def require_references(references: References, group: str, task_ids: Sequence[str], path: str) -> None:
    """Checks that every task of a group has a reference.

    Args:
        references: floors and ceilings.
        group: the group's name.
        task_ids: its tasks.
        path: the file that should have them, for the error.

    Raises:
        BenchError: a task has none.
    """
    missing = references.missing(task_ids)
    if missing:
        message = f"It has no floor and ceiling for {missing[0]} of group {group}."
        hint = "Measure it with: gym-extensions maintain references."
        raise BenchError("missing-reference", message, path, hint)


def load_references(version: str = CURRENT) -> References:
    """The references of a benchmark version, without tasks if its file does not exist.

    Raises:
        BenchError: the file does not hold references.
    """
    path = REFERENCES / f"{version}.json"
    return read_references(path) if path.exists() else References(version, {})
