"""Highlights of a scorecard name the task that is forgotten, helped or hurt most, in one sentence each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gym_extensions.scoring.metrics import learned_nothing
from gym_extensions.scoring.scorecard import GroupScore
from gym_extensions.scoring.statistics import holm, summary, zero_mean_p

LEAST_CHANGE = 0.05
"""The smallest change of normalized return that is reported."""


@dataclass(frozen=True)
class Contrast:
    """Two columns of the paper's table whose difference is worth a sentence.

    Attributes:
        sentence: the sentence, with places for the task, the return before and the return after.
        before: one column.
        after: the other.
        sign: 1 for an increase, −1 for a decrease.
        first_task: position of the first task that is compared.
        last_tasks_left_out: number of tasks at the end that are not compared.
    """

    sentence: str
    before: str
    after: str
    sign: int
    first_task: int = 0
    last_tasks_left_out: int = 0


@dataclass(frozen=True)
class Change:
    """A task's mean raw return in both columns of a contrast."""

    task: str
    before: float
    after: float


FORGETTING = Contrast(
    "forgets {} most: {} → {}", "after_env_training", "fully_trained", -1, last_tasks_left_out=1
)
CONTRASTS = (
    FORGETTING,
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


def _p_value(before: Sequence[float], after: Sequence[float]) -> float:
    """The p value of the paired t test over runs. With a single run there is no test: it is 0."""
    if min(len(before), len(after)) < 2:
        return 0.0
    return zero_mean_p(summary([b - a for a, b in zip(before, after, strict=True)]))


def _span(score: GroupScore, task: str) -> float | None:
    reference = score.reference[task]
    if reference.expert is None or reference.floor is None:
        return None
    return reference.expert - reference.floor


def largest_change(score: GroupScore, single: GroupScore | None, contrast: Contrast) -> Change | None:
    """The task that changes most, in units of the tasks' spans from floor to expert.

    A change counts if it is at least .05 of the span and a paired t test over runs finds it, at 5 % with
    Holm's correction over the tasks; a single run has no test, and counts. Tasks without a span count only if
    no task has one. An agent that learned nothing has no change.

    Args:
        score: a group's sequential scores.
        single: its single-task scores, if the entry has them.
        contrast: what is compared.
    """
    last = len(score.paper_table) - contrast.last_tasks_left_out
    tasks = []
    for index, row in enumerate(score.paper_table):
        before, after = row.cell(contrast.before), row.cell(contrast.after)
        if before and after and contrast.first_task <= index < last:
            tasks.append((index, Change(row.task, before.mean, after.mean)))
    if learned_nothing(score.metrics) or not tasks:
        return None
    tasks = [each for each in tasks if _span(score, each[1].task) is not None] or tasks
    p_values = [
        _p_value(*(_runs(score, single, index, column) for column in (contrast.before, contrast.after)))
        for index, _ in tasks
    ]
    best, largest = None, 0.0
    for (_, change), is_found in zip(tasks, holm(np.array(p_values)), strict=True):
        span = _span(score, change.task)
        size = contrast.sign * (change.after - change.before) / (span or 1.0)
        if is_found and size > largest and (span is None or size >= LEAST_CHANGE):
            best, largest = change, size
    return best


def highlights(score: GroupScore, single: GroupScore | None = None) -> list[str]:
    """Sentences on one group: its largest changes, and its open tasks. Empty if there are none.

    Args:
        score: the group's sequential scores.
        single: its single-task scores, if the entry has them.
    """
    sentences = []
    for contrast in CONTRASTS:
        if change := largest_change(score, single, contrast):
            means = (f"{value:.0f}" for value in (change.before, change.after))
            sentences.append(contrast.sentence.format(task_name(change.task), *means))
    open_tasks = [task_name(row.task) for row in score.paper_table if score.reference[row.task].open]
    if open_tasks:
        sentences.append(f"open (no expert), left out of normalized means: {', '.join(open_tasks)}")
    return sentences
