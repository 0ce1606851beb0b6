"""The rows of a submission's CSV files, and their writers (docs/rollout-log.md)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from gym_extensions.atomic import write_text

SUCCESS = "success"
"""The column whose cells are empty where the task defines no success."""
EPISODE_COLUMNS = (
    *("run", "stage", "task", "episode", "seed", "length", "return", "terminated"),
    *(SUCCESS, "trace", "fingerprint"),
)
UNBOUND_COLUMNS = tuple(name for name in EPISODE_COLUMNS if name != "trace")
"""The columns of a log that commits to no traces, as logs were written before ADR 78."""
CURVE_COLUMNS = ("protocol", "run", "task", "step", "return")
EVALUATION_COLUMNS = ("protocol", "run", "stage", "task", "step", "episodes", "return")


@dataclass(frozen=True)
class Episode:
    """One evaluation episode, one row of ``<protocol>.csv``.

    ``stage`` is the number of tasks trained so far (0 untrained; 1 in single and joint logs), ``return_`` the
    ``math.fsum`` of all rewards, ``terminated`` whether the task ended it (else the time limit did),
    ``success`` the ``is_success`` of its last step, or None where the task defines none, ``trace`` the digest
    of its trace (:func:`gym_extensions.rollouts.auditing.digests.trace_digest`), empty without one.
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
    trace: str = ""


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


@dataclass(frozen=True)
class EvaluationPoint:
    """One row of ``evaluations.csv``, an evaluation of a task while the stage goes on.

    ``step`` counts training steps since the stage began, ``return_`` is the mean over ``episodes`` episodes
    from the first of the task's prescribed seeds.
    """

    protocol: str
    run: int
    stage: int
    task: str
    step: int
    episodes: int
    return_: float


def _cell(value: object) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    return repr(value) if isinstance(value, float) else str(value)


def _values(row: Episode | CurvePoint | EvaluationPoint) -> tuple[object, ...]:
    """The values in the order of the fields; ``dataclasses.astuple`` copies each, which is slow."""
    return tuple(vars(row).values())


def _lines(rows: Iterable[tuple[object, ...]]) -> str:
    return "".join(",".join(map(_cell, row)) + "\n" for row in rows)


def _text(header: tuple[str, ...], rows: Iterable[CurvePoint | EvaluationPoint]) -> str:
    return ",".join(header) + "\n" + _lines(map(_values, rows))


def write_episodes(path: Path, episodes: Iterable[Episode], task_ids: tuple[str, ...]) -> None:
    """Writes an evaluation log, sorted by run, stage, task in training order, episode.

    If no episode has a trace, as in the logs of the references, the column ``trace`` is left out.
    """
    position = {task: index for index, task in enumerate(task_ids)}
    ordered = sorted(episodes, key=lambda row: (row.run, row.stage, position[row.task], row.episode))
    columns, cells = UNBOUND_COLUMNS, [_values(row)[:-1] for row in ordered]
    if any(row.trace for row in ordered):
        columns = EPISODE_COLUMNS
        cells = [(*row[:-1], each.trace, row[-1]) for row, each in zip(cells, ordered, strict=True)]
    write_text(path, ",".join(columns) + "\n" + _lines(cells))


def write_curves(path: Path, points: Iterable[CurvePoint], task_ids: tuple[str, ...]) -> None:
    """Writes the training curves, sorted by protocol, run, task in training order, step."""
    position = {task: index for index, task in enumerate(task_ids)}
    ordered = sorted(points, key=lambda row: (row.protocol, row.run, position[row.task], row.step))
    write_text(path, _text(CURVE_COLUMNS, ordered))


def write_evaluations(path: Path, points: Iterable[EvaluationPoint], task_ids: tuple[str, ...]) -> None:
    """Writes evaluations during training, sorted by protocol, run, stage, step and task in training order."""
    position = {task: index for index, task in enumerate(task_ids)}
    ordered = sorted(points, key=lambda row: (row.protocol, row.run, row.stage, row.step, position[row.task]))
    write_text(path, _text(EVALUATION_COLUMNS, ordered))


def append_curves(path: Path, points: Iterable[CurvePoint]) -> None:
    """Appends points to the curve of an unfinished stage. Without a file, writes the header first."""
    if not path.exists():
        write_text(path, _text(CURVE_COLUMNS, ()))
    with path.open("a", encoding="utf-8", newline="\n") as file:
        file.write(_lines(map(_values, points)))
