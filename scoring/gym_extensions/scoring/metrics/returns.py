"""Checked logs -> the raw returns of a group as arrays. Every cell exists."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.budgets import BUDGETS
from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.catalog.protocol import EVALUATION_EPISODES, stages
from gym_extensions.rollouts.reading.evaluation_log import Log
from gym_extensions.rollouts.reading.training_curves import Curves, Key
from gym_extensions.rollouts.submission import SubmittedGroup

Returns = NDArray[np.float64]
Cells = list[list[list[list[float]]]]
Means = list[list[list[float]]]
Rates = tuple[tuple[tuple[float | None, ...], ...], ...]
Successes = NDArray[np.int8]
Curve = tuple[list[int], list[float]]
"""A training curve: steps, and the mean return of the training episodes that ended since the point before."""


@dataclass(frozen=True)
class Results:
    """Raw returns of a group.

    Attributes:
        group: the group.
        steps: the budget's training steps per task.
        runs: training seeds by protocol.
        sequential: returns [run, stage, task, episode], or None without the log.
        single: returns [run, task, episode], or None without the log.
        joint: returns [run, task, episode], or None without the log.
        curves: training curves by (protocol, run, task id).
        successes: [run, stage, task, episode] by protocol: 1, 0, or -1 where the task defines no success.
    """

    group: TaskGroup
    steps: int
    runs: dict[str, tuple[int, ...]]
    sequential: Returns | None = None
    single: Returns | None = None
    joint: Returns | None = None
    curves: dict[Key, Curve] = field(default_factory=dict)
    successes: dict[str, Successes] = field(default_factory=dict)

    @functools.cached_property
    def returns(self) -> dict[str, Cells]:
        """Returns [run][stage][task][episode] by protocol. Single and joint logs have one stage."""
        arrays = {
            "sequential": self.sequential,
            "single": None if self.single is None else self.single[:, None],
            "joint": None if self.joint is None else self.joint[:, None],
        }
        return {protocol: array.tolist() for protocol, array in arrays.items() if array is not None}

    @functools.cached_property
    def means(self) -> dict[str, Means]:
        """Mean raw returns [run][stage][task] by protocol, by ``math.fsum``."""
        return {
            protocol: [[[math.fsum(cell) / len(cell) for cell in row] for row in run] for run in runs]
            for protocol, runs in self.returns.items()
        }


def _shape(log: Log) -> tuple[int, int, int, int]:
    """Runs, stages, tasks and episodes of a log."""
    tasks = len(log.group.tasks)
    return len(log.runs), len(stages(log.protocol, tasks)), tasks, EVALUATION_EPISODES


def _array(log: Log | None) -> Returns | None:
    if log is None:
        return None
    shape = _shape(log)
    if log.return_.size != np.prod(shape):
        raise ValueError(f"{log.path} is not a complete log.")
    cells = log.return_.reshape(shape)
    return cells if log.protocol == "sequential" else cells[:, 0]


def success_rates(successes: Successes) -> Rates:
    """The share of episodes that succeeded, [run][stage][task].

    None where the task defines no success; empty if no task does.

    Args:
        successes: [run, stage, task, episode]; 1, 0, or -1 where the task defines none.
    """
    if (successes < 0).all():
        return ()
    return tuple(
        tuple(tuple(None if min(cell) < 0 else sum(cell) / len(cell) for cell in row) for row in run)
        for run in successes.tolist()
    )


def _curves(curves: Curves | None) -> dict[Key, Curve]:
    if curves is None:
        return {}
    steps, values = curves.step.tolist(), curves.return_.tolist()
    return {key: (steps[start:stop], values[start:stop]) for key, start, stop in curves.blocks}


def results(entry: SubmittedGroup, budget: str) -> Results:
    """The returns of a group's checked logs."""
    return Results(
        group=entry.group,
        steps=BUDGETS[budget].steps_for(entry.group.name),
        runs={protocol: log.runs for protocol, log in entry.logs.items()},
        sequential=_array(entry.logs.get("sequential")),
        single=_array(entry.logs.get("single")),
        joint=_array(entry.logs.get("joint")),
        curves=_curves(entry.curves),
        successes={protocol: log.success.reshape(_shape(log)) for protocol, log in entry.logs.items()},
    )
