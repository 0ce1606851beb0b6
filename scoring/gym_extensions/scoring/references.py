"""Frozen floors and ceilings that normalize returns. 0 ignores observations, 1 is the reference agent."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from gym_extensions.errors import BenchError

REFERENCES = Path(__file__).parent / "references_data"
CURRENT = "1"
"""The benchmark version whose references normalize every score."""


@dataclass(frozen=True)
class Reference:
    """A task's floor and ceiling in raw returns; a task that no agent has learned has no ceiling.

    Raises:
        ValueError: a solved task without a ceiling above its floor, or an unsolved one with a ceiling.
    """

    floor: float
    ceiling: float | None
    unsolved: bool

    def __post_init__(self) -> None:
        solved = self.ceiling is not None and math.isfinite(self.ceiling) and self.ceiling > self.floor
        if not math.isfinite(self.floor) or not (self.ceiling is None if self.unsolved else solved):
            raise ValueError(
                f"A reference is unsolved without a ceiling, or has a ceiling above its floor: {self}."
            )

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
    provisional: bool
    tasks: dict[str, Reference]
    digest: str = ""

    def missing(self, task_ids: Sequence[str]) -> list[str]:
        """The tasks without a reference."""
        return [task for task in task_ids if task not in self.tasks]


def parse_references(data: bytes) -> References:
    """The references of a JSON file of format 1 (docs/metrics.md).

    Raises:
        ValueError: another format.
    """
    document = json.loads(data)
    if document.get("format") != 1:
        raise ValueError("References have format 1.")
    tasks = {
        name: Reference(
            floor=float(row["floor"]["mean"]),
            ceiling=None if row["ceiling"] is None else float(row["ceiling"]["mean"]),
            unsolved=bool(row["unsolved"]),
        )
        for name, row in document["tasks"].items()
        if "ceiling" in row  # the reference runs of the other tasks are not measured yet
    }
    digest = hashlib.sha256(data).hexdigest()
    return References(str(document["version"]), bool(document["provisional"]), tasks, digest)


def add_references(published: References, own: References) -> References:
    """The published references and a user's own for further tasks.

    A published reference is never replaced. The version and the digest name both files.
    """
    return References(
        version=f"{published.version} + {own.version}",
        provisional=published.provisional or own.provisional,
        tasks=own.tasks | published.tasks,
        digest=hashlib.sha256(f"{published.digest} {own.digest}".encode()).hexdigest(),
    )


def read_references(path: Path) -> References:
    """The references of a file that ``gym-extensions reference`` wrote.

    Raises:
        BenchError: the file cannot be read or does not hold references.
    """
    try:
        return parse_references(path.read_bytes())
    except OSError as error:
        raise BenchError("unreadable-references", f"{error.strerror or error}.", str(path)) from error
    except (ValueError, KeyError, TypeError) as error:
        hint = "Write it with: gym-extensions reference."
        raise BenchError(
            "malformed-references", "The file does not hold references.", str(path), hint
        ) from error


def load_references(version: str = CURRENT) -> References:
    """The references of a benchmark version, without tasks if its file does not exist."""
    path = REFERENCES / f"{version}.json"
    if not path.exists():
        return References(version, True, {})
    return parse_references(path.read_bytes())
