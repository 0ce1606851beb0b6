"""What floor and ceiling of a task were measured with, in words."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

from gym_extensions.scoring.references import REFERENCES, load_references
from gym_extensions.scoring.scorecard.model import ReferencesInfo


@dataclass(frozen=True)
class Measured:
    """How a task's floor and ceiling were measured.

    Args:
        floor: mean return of the agent that ignores observations.
        floor_agent: its name.
        agent: the reference agent; empty if no attempt is recorded.
        budget: its training budget; empty for an agent that is not trained.
        runs: the mean return of each reference run.
        ceiling: their mean; None for an unsolved task, whose runs are attempts, and without reference runs.
        error: the standard error of the ceiling over runs; None where it is not recorded.
        floor_error: the standard error of the floor over its episodes; None where it is not recorded.
        floor_episodes: the number of these episodes.
    """

    floor: float
    floor_agent: str
    agent: str
    budget: str
    runs: tuple[float, ...]
    ceiling: float | None
    error: float | None = None
    floor_error: float | None = None
    floor_episodes: int = 0

    @property
    def is_unsolved(self) -> bool | None:
        """Whether no reference agent learned the task; None if none was trained on it."""
        return self.ceiling is None if self.agent else None


@cache
def measured(info: ReferencesInfo) -> Mapping[str, Measured]:
    """By task id, from the file of this benchmark version; empty if its digest is another."""
    if not info.sha256 or load_references(info.version).digest != info.sha256:
        return {}
    document = json.loads((REFERENCES / f"{info.version}.json").read_bytes())
    return {task: _measured(row) for task, row in document["tasks"].items()}


def _measured(row: dict[str, dict[str, object] | None]) -> Measured:
    floor, ceiling = row["floor"] or {}, row.get("ceiling")
    best = ceiling or row.get("attempts") or {}
    runs = best.get("runs")
    return Measured(
        floor=float(str(floor["mean"])),
        floor_agent=str(floor["agent"]),
        floor_error=_number(floor.get("standard_error")),
        floor_episodes=int(str(floor.get("episodes") or 0)),
        agent=str(best.get("agent") or ""),
        budget=str(best.get("budget") or ""),
        runs=tuple(float(run["mean"]) for run in runs) if isinstance(runs, list) else (),
        ceiling=float(str(ceiling["mean"])) if ceiling else None,
        error=_number(best.get("standard_error")),
    )


def _number(value: object) -> float | None:
    return value if isinstance(value, float) else None
