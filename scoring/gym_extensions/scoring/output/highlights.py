"""Highlights of a scorecard name the task that is forgotten, helped or hurt most, in one sentence each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gym_extensions.scoring.formulas import learned_nothing
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
        tasks: the positions that are compared.
    """

    sentence: str
    before: str
    after: str
    sign: int
    tasks: slice


@dataclass(frozen=True)
class Change:
    """A task's mean raw return in both columns of a contrast."""

    task: str
    before: float
    after: float


AFTER = "after_env_training"
FORGETTING = Contrast("forgets {} most: {} → {}", AFTER, "fully_trained", -1, slice(None, -1))
HELP = "earlier tasks help {} most: {} alone, {} after them"
HARM = "earlier tasks hurt {} most: {} alone, {} after them"
CONTRASTS = (
    FORGETTING,
    Contrast(HELP, "single_env", AFTER, 1, slice(1, None)),
    Contrast(HARM, "single_env", AFTER, -1, slice(1, None)),
)


def task_name(task_id: str) -> str:
    """A task's name without namespace and version."""
    return task_id.rpartition("/")[2].rpartition("-v")[0] or task_id


def _runs(score: GroupScore, single: GroupScore | None, index: int, column: str) -> list[float]:
    """The mean return of each run behind a cell of the paper's table, empty for a published table."""
    if column == "single_env":
        return [run[-1][index] for run in single.return_matrix] if single else []
    stage = {"fully_trained": -1, AFTER: index + 1}[column]
    return [run[stage][index] for run in score.return_matrix]


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
    changes, spans, p_values = [], [], []
    for index, row in list(enumerate(score.paper_table))[contrast.tasks]:
        before, after = row.cell(contrast.before), row.cell(contrast.after)
        if not before or not after:
            continue
        runs = [_runs(score, single, index, column) for column in (contrast.before, contrast.after)]
        is_tested = min(map(len, runs)) > 1
        differences = [b - a for a, b in zip(*runs, strict=True)] if is_tested else []
        changes.append(Change(row.task, before.mean, after.mean))
        spans.append(score.reference[row.task].span)
        p_values.append(zero_mean_p(summary(differences)) if is_tested else 0.0)
    if learned_nothing(score.metrics) or not changes:
        return None
    chosen = [index for index, span in enumerate(spans) if span is not None] or range(len(changes))
    best, largest = None, 0.0
    for index, is_found in zip(chosen, holm(np.array([p_values[index] for index in chosen])), strict=True):
        change, span = changes[index], spans[index]
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
