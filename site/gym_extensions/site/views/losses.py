"""The task of a trial that lost most of its score."""

from __future__ import annotations

from dataclasses import dataclass

from gym_extensions.scoring.metrics.value import LEAST_LEARNED
from gym_extensions.scoring.statistics.intervals import interval
from gym_extensions.site.views.trial import Trial

LEAST_LOST = 0.05
"""The smallest loss of normalized return that is reported."""


@dataclass(frozen=True)
class Loss:
    """A task's mean raw return right after its training, and at the end."""

    task: str
    before: float
    after: float


def largest_loss(trial: Trial) -> Loss | None:
    """The task with a ceiling that lost most of its normalized return (mean over runs); None below .05.

    As for the highlights of ``score``, a loss counts if its 95 % interval over runs excludes 0. A single run
    has no interval, and counts.
    """
    if (trial.metric("learning_performance").mean or 0.0) < LEAST_LEARNED or not trial.stage_matrices:
        return None
    mean = trial.mean_matrix
    losses = []
    for index, task in enumerate(trial.tasks[:-1]):
        low = interval([run[index + 1][index] - run[-1][index] for run in trial.stage_matrices]).low
        before, after = mean[index + 1][index], mean[-1][index]
        reference = trial.reference(task)
        scores = [reference.normalize(value) for value in (before, after)] if reference else []
        present = [score for score in scores if score is not None]
        if len(present) == 2 and (low is None or low > 0):
            losses.append((present[0] - present[1], -index, Loss(task, before, after)))
    worst = max(losses, default=None, key=lambda loss: loss[:2])
    return worst[2] if worst and worst[0] >= LEAST_LOST else None
