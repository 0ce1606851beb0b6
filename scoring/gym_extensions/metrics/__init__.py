"""Metrics of continual learning from a matrix of returns, whatever produced it: the reference implementation.

The formulas are those of the scorecards (docs/metrics.md), computed by the same functions. Other
implementations can be tested with the conformance kit, JSON files in ``gym_extensions/scoring/conformance``.

>>> from gym_extensions import metrics
>>> values = metrics.compute([[1.0, 0.0], [0.5, 1.0]])  # row: tasks trained so far; column: task
>>> values["forgetting"].mean
0.5
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gym_extensions.errors import BenchError
from gym_extensions.scoring.metrics import (
    FINAL,
    JOINT_GAP,
    TABLE,
    Metric,
    MetricValue,
    Profile,
    Run,
    area,
    iqm,
    profile,
)
from gym_extensions.scoring.returns import joint_gap, over_runs
from gym_extensions.scoring.statistics import Interval, difference, interval

__all__ = [
    "FORMULAS",
    "Interval",
    "MetricValue",
    "Profile",
    "area",
    "compute",
    "difference",
    "interval",
    "iqm",
    "profile",
]

Array = NDArray[np.float64]

FORMULAS = {metric.name: metric.formula for metric in TABLE}
"""The formula of every metric, by name."""

INPUTS = {name: name for name in ("single", "joint", "cumulative")} | {"curves": "auc and single_auc"}
NEEDS_STAGE_0 = ("zero_shot_transfer", "generalization_to_unseen_tasks")
NEEDS_EPISODES = ("return_std", "cvar_10")


def compute(
    matrix: ArrayLike,
    single: ArrayLike | None = None,
    *,
    joint: ArrayLike | None = None,
    cumulative: ArrayLike | None = None,
    episodes: ArrayLike | None = None,
    auc: ArrayLike | None = None,
    single_auc: ArrayLike | None = None,
    floor: ArrayLike | None = None,
    expert: ArrayLike | None = None,
) -> dict[str, MetricValue]:
    """Every metric of one or more runs on a sequence of T tasks.

    Args:
        matrix: ([runs,] T or T + 1, T). Row s, column j is the mean return (or success rate) on task j after
            training on s tasks. With T + 1 rows, the first is the untrained agent.
        single: ([runs,] T), the same of an agent trained on task j alone, for asymptotic transfer.
        joint: ([runs,] T), the same of an agent trained on all tasks at once, for the joint gap. Its number
            of runs may differ.
        cumulative: ([runs]), the return on task T of an agent trained on it alone for the steps of all tasks.
        episodes: ([runs,] T, episodes), the returns of single episodes after the last task, for their
            standard deviation and their worst tenth.
        auc: ([runs,] T), the area under the training curve of task j (:func:`area`), for forward transfer.
        single_auc: ([runs,] T), the same of an agent trained on task j alone.
        floor: (T,) returns that count as 0; 0 by default.
        expert: (T,) returns that count as 1; 1 by default. A task whose expert is None or NaN is left out
            of every mean.

    Returns:
        The value of every metric by name, in the order of docs/metrics.md: ``mean``, ``low`` and ``high``
        (95 % interval, from two runs), ``runs`` (one value per run), and ``why`` where one is missing.

    Raises:
        BenchError: an argument has another shape or contains something that is not a finite number
            (``bad-matrix``), or an expert is not above its floor (``bad-expert``).
    """
    values = _array("matrix", matrix, 2)
    runs, rows, tasks = values.shape
    if rows not in (tasks, tasks + 1):
        hint = f"Give {tasks} rows, or {tasks + 1} with the untrained agent first."
        raise BenchError("bad-matrix", f"It has {rows} rows and {tasks} columns.", "matrix", hint)
    scored, low, height = _scale(floor, expert, tasks)

    def normalized(name: str, given: ArrayLike | None, axes: int, task_axis: int, count: int) -> Array | None:
        if given is None:
            return None
        array = _array(name, given, axes)
        if array.shape[task_axis] != tasks or (count and len(array) != count):
            expected = f"{f'{count} runs' if count else 'any number of runs'} and {tasks} tasks"
            raise BenchError("bad-matrix", f"Its shape is {array.shape}.", name, f"Give {expected}.")
        shape = [1] * array.ndim
        shape[task_axis] = tasks
        return (array - low.reshape(shape)) / height.reshape(shape)

    p = normalized("matrix", values, 2, -1, runs)
    alone = normalized("single", single, 1, -1, runs)
    together = normalized("joint", joint, 1, -1, 0)
    practiced = None
    if cumulative is not None:  # as an array with tasks, of which the last alone counts
        column = _array("cumulative", cumulative, 0)
        practiced = normalized("cumulative", np.tile(column[:, None], tasks), 1, -1, runs)
    last = normalized("episodes", episodes, 2, -2, runs)
    areas = normalized("auc", auc, 1, -1, runs)
    single_areas = normalized("single_auc", single_auc, 1, -1, runs)
    assert p is not None
    first = tasks + 1 - rows

    def by_task(array: Array | None, run: int) -> dict[int, float]:
        return {} if array is None else {j: float(array[run, j - 1]) for j in scored}

    found = [
        Run(
            T=tasks,
            scored=scored,
            normalized_returns={
                (s, j): float(row[j - 1]) for s, row in enumerate(p[index], first) for j in scored
            },
            final_episodes={} if last is None else {j: tuple(last[index, j - 1].tolist()) for j in scored},
            single_task=by_task(alone, index),
            auc=by_task(areas, index),
            single_task_auc=by_task(single_areas, index),
            cumulative=by_task(practiced, index),
        )
        for index in range(runs)
    ]
    given = {"single": single is not None, "joint": joint is not None, "cumulative": cumulative is not None}
    given["curves"] = auc is not None and single_auc is not None

    def value(metric: Metric) -> MetricValue:
        lacking = [INPUTS[name] for name in _needs(metric) if not given[name]]
        if metric.name in NEEDS_STAGE_0 and first:
            lacking.append("a first row of the untrained agent")
        if metric.name in NEEDS_EPISODES and episodes is None:
            lacking.append("episodes")
        if lacking:
            return MetricValue(why=f"It needs {' and '.join(lacking)}.")
        if metric is JOINT_GAP and together is not None:
            return joint_gap(over_runs(FINAL, found), over_runs(FINAL, _last_stage(together, scored)))
        if metric.protocols == ("cumulative",) and practiced is not None:
            return over_runs(metric, _last_stage(practiced, scored))
        return over_runs(metric, found)

    return {metric.name: value(metric) for metric in TABLE}


def _needs(metric: Metric) -> tuple[str, ...]:
    """The inputs of a metric beside the matrix. The area alone is enough for forward transfer."""
    if "curves" in metric.needs:
        return ("curves",)
    return metric.needs if "sequential" in metric.protocols else metric.protocols


def _last_stage(array: Array, scored: Sequence[int]) -> list[Run]:
    """Runs of which nothing but the last stage is known, (runs, T)."""
    T = array.shape[1]
    return [Run(T, tuple(scored), {(T, j): float(row[j - 1]) for j in scored}) for row in array]


def _scale(
    floor: ArrayLike | None, expert: ArrayLike | None, tasks: int
) -> tuple[tuple[int, ...], Array, Array]:
    """The positions of the tasks with an expert, the floors, and the experts' heights above them, (T,)."""
    low = np.zeros(tasks) if floor is None else _finite("floor", _numbers("floor", floor))
    high = np.ones(tasks) if expert is None else _numbers("expert", expert)
    for name, array in (("floor", low), ("expert", high)):
        if array.shape != (tasks,):
            raise BenchError("bad-matrix", f"Its shape is {array.shape}.", name, f"Give {tasks} numbers.")
    open_ = np.isnan(high)
    bad = ~open_ & ~((high > low) & np.isfinite(high))
    if bad.any():
        j = int(np.flatnonzero(bad)[0])
        message = f"The expert of task {j + 1} is {high[j]:g}, its floor {low[j]:g}."
        raise BenchError("bad-expert", message, "expert", "Give a higher one, or NaN to leave the task out.")
    scored = tuple((np.flatnonzero(~open_) + 1).tolist())
    return scored, low, np.where(open_, 1.0, high - low)


def _numbers(name: str, given: ArrayLike) -> Array:
    try:
        return np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError) as error:
        message = "It is not an array of numbers."
        raise BenchError("bad-matrix", message, name, "Give rows of equal length.") from error


def _array(name: str, given: ArrayLike, axes: int) -> Array:
    """An array with an axis of runs before its other axes.

    Raises:
        BenchError: it is empty, has another number of axes, or contains a number that is not finite.
    """
    array = _numbers(name, given)
    if array.ndim not in (axes, axes + 1) or 0 in array.shape:
        hint = f"Give {axes} axes, or {axes + 1} with the runs first."
        raise BenchError("bad-matrix", f"Its shape is {array.shape}.", name, hint)
    return _finite(name, array).reshape(-1, *array.shape[array.ndim - axes :])


def _finite(name: str, array: Array) -> Array:
    if not np.isfinite(array).all():
        place = tuple(np.argwhere(~np.isfinite(array))[0].tolist())
        message = f"The value at index {list(place)} is {array[place]}."
        raise BenchError("bad-matrix", message, name, "Leave out runs and tasks without results.")
    return array
