"""Training curves that the author of a policy states."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise

from gym_extensions.baselines.training.jobs import Stage, TrainingJob
from gym_extensions.baselines.training.recorder import EXCESS
from gym_extensions.catalog.task import Task
from gym_extensions.errors import BenchError, did_you_mean
from gym_extensions.rollouts.episodes import CurvePoint

ClaimedCurves = Mapping[str, Sequence[tuple[int, float]]]
"""By task name or id: pairs of training steps in the stage and mean return of the episodes since the last."""


def task_named(name: str, tasks: Sequence[Task]) -> Task:
    """The task with that name or id. Raises ``BenchError`` if there is none."""
    for task in tasks:
        if name in (task.name, task.id):
            return task
    hint = did_you_mean(str(name), [task.name for task in tasks])
    raise BenchError("unknown-task", f"{name!r} is not a task of this group or stage.", "task", hint)


def curve_points(job: TrainingJob, stage: Stage, curves: ClaimedCurves) -> list[CurvePoint]:
    """The points of a stage's training curves.

    Raises:
        BenchError: a task is not trained in the stage, steps do not increase or exceed the budget, or a
            return is not finite.
    """
    points = []
    for name, values in curves.items():
        task = task_named(name, stage.trained)
        steps = [int(step) for step, _ in values]
        if any(later <= earlier for earlier, later in pairwise([0, *steps])):
            raise _bad_curve(name, "The training steps do not increase.", "Start above 0.")
        if steps and steps[-1] > stage.steps * (1 + EXCESS):
            message = f"It ends at step {steps[-1]}; the budget is {stage.steps}."
            raise _bad_curve(name, message, "Choose the budget that the policy was trained with.")
        if not all(math.isfinite(value) for _, value in values):
            raise _bad_curve(name, "A return is not finite.", "Leave such points out.")
        points += [
            CurvePoint(job.protocol, job.run, task.id, int(step), float(value)) for step, value in values
        ]
    return points


def _bad_curve(name: str, message: str, hint: str) -> BenchError:
    return BenchError("bad-curve", message, f"curves[{name!r}]", hint)
