"""Highlights of a scorecard name the task that is forgotten, helped or hurt most, in one sentence each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from gym_extensions.scoring.metrics.paper_table import PaperRow
from gym_extensions.scoring.scorecard.model import GroupScore
from gym_extensions.scoring.statistics.intervals import interval


@dataclass(frozen=True)
class Contrast:
    """A change between two columns of the paper's table that is worth a sentence."""

    sentence: str
    before: str
    after: str
    sign: int
    first_task: int = 0
    last_tasks_left_out: int = 0


CONTRASTS = (
    Contrast("forgets {} most: {} → {}", "after_env_training", "fully_trained", -1, last_tasks_left_out=1),
    Contrast(
        "earlier tasks help {} most: {} alone, {} after them",
        "single_env",
        "after_env_training",
        1,
        first_task=1,
    ),
    Contrast(
        "earlier tasks hurt {} most: {} alone, {} after them",
        "single_env",
        "after_env_training",
        -1,
        first_task=1,
    ),
)


def task_name(task_id: str) -> str:
    """A task's name without namespace and version."""
    return task_id.rsplit("/", 1)[-1].rsplit("-v", 1)[0]


def _runs(score: GroupScore, single: GroupScore | None, index: int, column: str) -> list[float]:
    """The mean return of each run behind a cell of the paper's table, empty for a published table."""
    if column == "single_env":
        return [run[-1][index] for run in single.return_matrix] if single else []
    stage = {"fully_trained": -1, "after_env_training": index + 1}[column]
    return [run[stage][index] for run in score.return_matrix]


def _is_significant(before: Sequence[float], after: Sequence[float], sign: int) -> bool:
    """Whether the change is significant in the given direction. A single run counts as significant."""
    if min(len(before), len(after)) < 2:
        return True
    low = interval([sign * (b - a) for a, b in zip(before, after, strict=True)]).low
    return low is not None and low > 0


def _changes(
    score: GroupScore, single: GroupScore | None, contrast: Contrast, rows: dict[int, PaperRow]
) -> dict[int, float]:
    """The significant changes by task index, in units of the task's span where it has one."""
    changes = {}
    for index, row in rows.items():
        before, after = row.cell(contrast.before), row.cell(contrast.after)
        runs_before = _runs(score, single, index, contrast.before)
        runs_after = _runs(score, single, index, contrast.after)
        if before and after and _is_significant(runs_before, runs_after, contrast.sign):
            changes[index] = contrast.sign * (after.mean - before.mean) / (_span(score, row.task) or 1.0)
    return changes


def _span(score: GroupScore, task: str) -> float | None:
    reference = score.reference[task]
    if reference.ceiling is None or reference.floor is None:
        return None
    return reference.ceiling - reference.floor


def highlights(score: GroupScore, single: GroupScore | None = None) -> list[str]:
    """Sentences on one group, empty if nothing is significant or the paper's table is missing.

    A change counts where its 95 % interval over runs does not contain 0. The largest is chosen in units of
    the tasks' spans from floor to ceiling; tasks without a span count only where no task has one.

    Args:
        score: the group's sequential scores.
        single: its single-task scores, if the entry has them.
    """
    sentences = []
    for contrast in CONTRASTS:
        last = len(score.paper_table) - contrast.last_tasks_left_out
        rows = {
            index: row
            for index, row in enumerate(score.paper_table)
            if contrast.first_task <= index < last and row.cell(contrast.before) and row.cell(contrast.after)
        }
        with_span = {index: row for index, row in rows.items() if _span(score, row.task) is not None}
        changes = _changes(score, single, contrast, with_span or rows)
        best = max(changes, key=changes.__getitem__, default=None)
        if best is not None and changes[best] > 0:
            cells = (rows[best].cell(column) for column in (contrast.before, contrast.after))
            means = (f"{cell.mean:.0f}" for cell in cells if cell)
            sentences.append(contrast.sentence.format(task_name(rows[best].task), *means))
    unsolved = [task_name(row.task) for row in score.paper_table if score.reference[row.task].unsolved]
    if unsolved:
        sentences.append(f"unsolved, left out of normalized means: {', '.join(unsolved)}")
    return sentences
