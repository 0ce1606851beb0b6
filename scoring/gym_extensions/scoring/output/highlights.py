"""Highlights of a scorecard name the task that is forgotten, helped or hurt most, in one sentence each."""

from __future__ import annotations

import re
from typing import NamedTuple

import numpy as np

from gym_extensions.metrics.statistics import holm, summary, zero_mean_p
from gym_extensions.metrics.values import learned_nothing
from gym_extensions.scoring.scorecard import GroupScore

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


class Change(NamedTuple):
    """A task's mean raw return in both columns of a contrast."""

    task: str
    before: float
    after: float


AFTER = "after_env_training"
FORGETTING = Contrast("forgets {} most: {} → {}", AFTER, "fully_trained", -1, slice(None, -1))
CONTRASTS = (
    FORGETTING,
    Contrast("earlier tasks help {} most: {} alone, {} after them", "single_env", AFTER, 1, slice(1, None)),
    Contrast("earlier tasks hurt {} most: {} alone, {} after them", "single_env", AFTER, -1, slice(1, None)),
)


def task_name(task_id: str) -> str:
    """A task's name without namespace and version."""
    return re.sub(r"-v\d+$", "", task_id.rpartition("/")[2])


def _runs(score: GroupScore, single: GroupScore | None, index: int, column: str) -> dict[int, float]:
    """The mean return of each run behind a cell of the paper's table, empty for a published table."""
    source, stage = score, {"fully_trained": -1, AFTER: index + 1}.get(column, -1)
    if column == "single_env":
        if single is None:
            return {}
        source = single
    return {run: means[stage][index] for run, means in zip(source.runs, source.return_matrix, strict=True)}


def largest_change(score: GroupScore, single: GroupScore | None, contrast: Contrast) -> Change | None:
    """The task that changes most, in units of the tasks' spans from floor to expert.

    A change counts if it is at least .05 of the span and a paired t test over the runs that both columns have
    finds it, at 5 % with Holm's correction over the tasks; a single run has no test, and counts. Tasks
    without a span count only if no task has one. An agent that learned nothing has no change. The arguments
    are those of :func:`highlights`, and what is compared.
    """
    if learned_nothing(score.metrics):
        return None
    found: list[tuple[Change, float | None, float]] = []  # with the span, and the p value
    for index, row in list(enumerate(score.paper_table))[contrast.tasks]:
        before, after = row.cell(contrast.before), row.cell(contrast.after)
        if before and after:
            first, second = (_runs(score, single, index, name) for name in (contrast.before, contrast.after))
            differences = [second[run] - first[run] for run in sorted(first.keys() & second.keys())]
            if first and not differences:
                continue
            p_value = zero_mean_p(summary(differences)) if len(differences) > 1 else 0.0
            change = Change(row.task, before.mean, after.mean)
            found.append((change, score.reference[row.task].span, p_value))
    chosen = [each for each in found if each[1] is not None] or found
    best, largest = None, 0.0
    for (change, span, _), is_found in zip(chosen, holm(np.array([p for *_, p in chosen])), strict=True):
        size = contrast.sign * (change.after - change.before) / (span or 1.0)
        if is_found and size > largest and (span is None or size >= LEAST_CHANGE):
            best, largest = change, size
    return best


def highlights(score: GroupScore, single: GroupScore | None = None) -> list[str]:
    """Sentences on a group with these sequential and single-task scores: largest changes, and open tasks."""
    changes = ((each, largest_change(score, single, each)) for each in CONTRASTS)
    sentences = [
        each.sentence.format(task_name(change.task), f"{change.before:.0f}", f"{change.after:.0f}")
        for each, change in changes
        if change
    ]
    open_tasks = [task_name(row.task) for row in score.paper_table if score.reference[row.task].open]
    if open_tasks:
        sentences.append(f"open (no expert), left out of normalized means: {', '.join(open_tasks)}")
    return sentences
