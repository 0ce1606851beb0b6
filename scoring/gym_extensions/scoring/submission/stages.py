"""What happens to each task over the stages: its scores, its change, and sentences on the largest changes."""

import re
from dataclasses import replace
from statistics import fmean
from typing import NamedTuple

import numpy as np

from gym_extensions.metrics.statistics import holm, interval, summary, zero_mean_p
from gym_extensions.metrics.values import learned_nothing
from gym_extensions.scoring.group_score import GroupScore, LargestChange, StageScore, TaskChange

LEAST_CHANGE = 0.05
"""The smallest change of normalized return that is reported."""


class Contrast(NamedTuple):
    """Two columns of the paper's table whose increase (sign 1) or decrease (−1) is worth a sentence.

    The sentence has places for the task and both returns; ``tasks`` are the positions that are compared.
    """

    sentence: str
    before: str
    after: str
    sign: int
    tasks: slice


AFTER = "after_env_training"
CONTRASTS = (
    Contrast("forgets {} most: {} → {}", AFTER, "fully_trained", -1, slice(None, -1)),
    Contrast("earlier tasks help {} most: {} alone, {} after them", "single_env", AFTER, 1, slice(1, None)),
    Contrast("earlier tasks hurt {} most: {} alone, {} after them", "single_env", AFTER, -1, slice(1, None)),
)


def task_name(task_id: str) -> str:
    """A task's name without namespace and version."""
    return re.sub(r"-v\d+$", "", task_id.rpartition("/")[2])


def largest_change(score: GroupScore, single: GroupScore | None, contrast: Contrast) -> LargestChange | None:
    """The task that changes most, in units of the tasks' spans from floor to expert.

    A change counts if it is at least .05 of the span and a paired t test over the runs that both columns have
    finds it, at 5 % with Holm's correction over the tasks; a single run has no test, and counts. Tasks
    without a span count only if no task has one. An agent that learned nothing has no change. The arguments
    are those of :func:`with_stages`, and what is compared.
    """

    def runs(index: int, column: str) -> dict[int, float]:
        """The mean return of each run behind a cell of the paper's table, empty for a published table."""
        source = single if column == "single_env" else score
        stage = {AFTER: index + 1}.get(column, -1)
        pairs = zip(source.runs, source.return_matrix, strict=True) if source else ()
        return {run: means[stage][index] for run, means in pairs}

    if learned_nothing(score.metrics):
        return None
    found: list[tuple[LargestChange, float | None, float]] = []  # with the span, and the p value
    for index, row in list(enumerate(score.paper_table))[contrast.tasks]:
        before, after = row.cell(contrast.before), row.cell(contrast.after)
        if before and after:
            first, second = (runs(index, name) for name in (contrast.before, contrast.after))
            differences = [second[run] - first[run] for run in sorted(first.keys() & second.keys())]
            p_value = zero_mean_p(summary(differences)) if len(differences) > 1 else 0.0
            change = LargestChange(row.task, before.mean, after.mean)
            found.append((change, score.reference[row.task].span, p_value))
    chosen = [each for each in found if each[1] is not None] or found
    best, largest = None, 0.0
    for (change, span, _), is_found in zip(chosen, holm(np.array([p for *_, p in chosen])), strict=True):
        size = contrast.sign * (change.after - change.before) / (span or 1.0)
        if is_found and size > largest and (span is None or size >= LEAST_CHANGE):
            best, largest = change, size
    return best


def with_stages(score: GroupScore, protocol: str, single: GroupScore | None = None) -> GroupScore:
    """The scores of a log with what follows for its tasks; ``single``: those of the single-task log."""
    changes = [largest_change(score, single, each) for each in CONTRASTS]
    sentences = [
        each.sentence.format(task_name(change.task), f"{change.before:.0f}", f"{change.after:.0f}")
        for each, change in zip(CONTRASTS, changes, strict=True)
        if change
    ]
    open_tasks = [task_name(row.task) for row in score.paper_table if score.reference[row.task].open]
    if open_tasks:
        sentences.append(f"open (no expert), left out of normalized means: {', '.join(open_tasks)}")
    scores = [score.scores(at) for at in range(len(score.tasks))]

    def cell(stage: int, at: int) -> StageScore:
        """The means over runs of a task after a stage."""
        rows, rates = scores[at], [run[stage][at] for run in score.success_rates]
        defined = [rate for rate in rates if rate is not None]
        value = interval([run[stage] for run in rows]) if rows else None
        return StageScore(
            *((value.mean, value.low, value.high) if value else ()),
            mean_return=fmean(run[stage][at] for run in score.return_matrix),
            success_rate=fmean(defined) if defined and len(defined) == len(rates) else None,
        )

    # The stages of balanced runs differ between runs.
    stages = range(len(score.return_matrix[0]) if score.return_matrix and protocol != "balanced" else 0)
    task_changes = []
    for at, normalized in enumerate(scores[:-1] if protocol == "sequential" and score.return_matrix else ()):
        rows = normalized or [[stage[at] for stage in run] for run in score.return_matrix]
        value = interval([row[-1] - row[at + 1] for row in rows])
        task_changes.append(TaskChange(value.mean, value.low, value.high, normalized=normalized is not None))
    return replace(
        score,
        stages=tuple(tuple(cell(stage, at) for at in range(len(score.tasks))) for stage in stages),
        changes=tuple(task_changes),
        top_score=max([1.0, *(value for rows in scores for row in rows or () for value in row)]),
        largest_loss=changes[0],
        highlights=tuple(sentences),
    )
