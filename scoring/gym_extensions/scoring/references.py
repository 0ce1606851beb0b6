"""Frozen floors and ceilings, and the normalised return: 0 is looking at nothing, 1 the reference."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

REFERENCES = Path(__file__).parent / "references_data"
CURRENT = "provisional"
"""The benchmark version whose references normalise every score; another one is another benchmark version."""


@dataclass(frozen=True)
class Reference:
    """A task's floor and ceiling in raw returns; an open task has no ceiling, nobody having learned it."""

    floor: float
    ceiling: float | None
    open: bool

    def __post_init__(self) -> None:
        scored = self.ceiling is not None and math.isfinite(self.ceiling) and self.ceiling > self.floor
        if (
            not math.isfinite(self.floor)
            or (self.open and self.ceiling is not None)
            or not (self.open or scored)
        ):
            raise ValueError(f"A reference is open without a ceiling, or has one above its floor: {self}.")

    def normalised(self, value: float) -> float:
        """(value − floor) / (ceiling − floor), not clipped; raises ValueError for an open task."""
        if self.ceiling is None:
            raise ValueError("An open task has no normalised return.")
        return (value - self.floor) / (self.ceiling - self.floor)

    def all_normalised(self, values: Iterable[float]) -> list[float]:
        """Every value normalised; raises ValueError for an open task."""
        if self.ceiling is None:
            raise ValueError("An open task has no normalised return.")
        floor, span = self.floor, self.ceiling - self.floor
        return [(value - floor) / span for value in values]


@dataclass(frozen=True)
class References:
    """The references of one benchmark version by task id; ``digest`` pins the file's bytes."""

    version: str
    provisional: bool
    tasks: dict[str, Reference]
    digest: str = ""

    def lacking(self, task_ids: Sequence[str]) -> list[str]:
        """The tasks that have no reference."""
        return [task for task in task_ids if task not in self.tasks]


def parse_references(data: bytes) -> References:
    """The references of a JSON file of format 1, which docs/metrics.md describes."""
    document = json.loads(data)
    if document.get("format") != 1:
        raise ValueError("References have format 1.")
    tasks = {
        name: Reference(
            floor=float(row["floor"]["mean"]),
            ceiling=None if row["ceiling"] is None else float(row["ceiling"]["mean"]),
            open=bool(row["open"]),
        )
        for name, row in document["tasks"].items()
    }
    digest = hashlib.sha256(data).hexdigest()
    return References(str(document["version"]), bool(document["provisional"]), tasks, digest)


def load_references(version: str = CURRENT) -> References:
    """The references of a benchmark version; without tasks where its file has not been made yet."""
    path = REFERENCES / f"{version}.json"
    if not path.exists():
        return References(version, True, {})
    return parse_references(path.read_bytes())
