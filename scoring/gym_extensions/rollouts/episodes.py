"""The rows of evaluation logs and training curves, and their writers (docs/rollout-log.md)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import astuple, dataclass
from pathlib import Path

from gym_extensions.atomic import write_text

SUCCESS = "success"
"""The column whose cells are empty where the task defines no success."""
EPISODE_COLUMNS = (
    *("run", "stage", "task", "episode", "seed", "length", "return", "terminated"),
    *(SUCCESS, "fingerprint"),
)
CURVE_COLUMNS = ("protocol", "run", "task", "step", "return")


@dataclass(frozen=True)
class Episode:
    """One evaluation episode, one row of ``<protocol>.csv``.

    ``stage`` is the number of tasks trained so far (0 untrained; 1 in single and joint logs), ``return_`` the
    ``math.fsum`` of all rewards, ``terminated`` whether the task ended it (else the time limit did),
    ``success`` the ``is_success`` of its last step, or None where the task defines none.
    """

    run: int
    stage: int
    task: str
    episode: int
    seed: int
    length: int
    return_: float
    terminated: bool
    success: bool | None
    fingerprint: str


@dataclass(frozen=True)
class CurvePoint:
    """One row of ``curves.csv``, the mean return of the training episodes that ended since the previous row.

    ``step`` counts training steps within the stage (sequential), the task (single) or the run (joint, where
    ``task`` names each task of the group in turn).
    """

    protocol: str
    run: int
    task: str
    step: int
    return_: float


def _cell(value: object) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    return repr(value) if isinstance(value, float) else str(value)


def _text(header: tuple[str, ...], rows: Iterable[Episode | CurvePoint]) -> str:
    lines = [",".join(header), *(",".join(map(_cell, astuple(row))) for row in rows)]
    return "\n".join(lines) + "\n"


def write_episodes(path: Path, episodes: Iterable[Episode], task_ids: tuple[str, ...]) -> None:
    """Writes an evaluation log, sorted by run, stage, task in training order, episode."""
    position = {task: index for index, task in enumerate(task_ids)}
    ordered = sorted(episodes, key=lambda row: (row.run, row.stage, position[row.task], row.episode))
    write_text(path, _text(EPISODE_COLUMNS, ordered))


def write_curves(path: Path, points: Iterable[CurvePoint], task_ids: tuple[str, ...]) -> None:
    """Writes the training curves, sorted by protocol, run, task in training order, step."""
    position = {task: index for index, task in enumerate(task_ids)}
    ordered = sorted(points, key=lambda row: (row.protocol, row.run, position[row.task], row.step))
    write_text(path, _text(CURVE_COLUMNS, ordered))
