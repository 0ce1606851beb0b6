"""Every metric of a matrix of returns: the reference implementation of the formulas."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from gym_extensions.errors import BenchError
from gym_extensions.metrics import formulas
from gym_extensions.metrics.formulas import finite, numbers
from gym_extensions.metrics.statistics import Array
from gym_extensions.metrics.values import MetricValue, joint_gap, over_runs

FORMULAS = {metric.name: metric.formula for metric in formulas.TABLE}
"""The formula of every metric, by name."""


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
    p, first = (values - low) / height, tasks + 1 - rows
    stages = range(first, tasks + 1)

    def normalized(name: str, given: ArrayLike) -> Array:
        """An array (runs, …, T)."""
        array = _array(name, given, {"cumulative": 0, "episodes": 2}.get(name, 1))
        if name == "episodes":
            array = array.swapaxes(1, 2)
        elif name == "cumulative":  # as an array with tasks, of which the last alone counts
            array = np.tile(array[:, None], tasks)
        count = len(array) if name == "joint" else runs
        if array.shape[-1] != tasks or len(array) != count:
            hint = f"Give {count} runs and {tasks} tasks."
            raise BenchError("bad-matrix", f"Its shape is {array.shape}.", name, hint)
        return (array - low) / height

    others = {"single": single, "joint": joint, "cumulative": cumulative, "episodes": episodes}
    others |= {"auc": auc, "single_auc": single_auc}
    found = {name: normalized(name, array) for name, array in others.items() if array is not None}

    def by_task(name: str, run: int) -> dict[int, Any]:
        return {j: found[name][run, ..., j - 1].tolist() for j in scored} if name in found else {}

    all_runs = [
        formulas.NormalizedRun(
            T=tasks,
            scored=scored,
            normalized_returns={(s, j): float(p[run, s - first, j - 1]) for s in stages for j in scored},
            final_episodes=by_task("episodes", run),
            single_task=by_task("single", run),
            auc=by_task("auc", run),
            single_task_auc=by_task("single_auc", run),
            cumulative=by_task("cumulative", run),
        )
        for run in range(runs)
    ]

    def value(metric: formulas.Metric) -> MetricValue:
        needs = metric.needs if "sequential" in metric.protocols else metric.protocols
        if "curves" in needs:  # the areas alone are enough for forward transfer
            needs = ("auc", "single_auc")
        present = {*found, "untrained"} if first == 0 else found.keys()
        words = {"untrained": "a first row of the untrained agent"}
        if lacking := [words.get(name, name) for name in needs if name not in present]:
            return MetricValue(why=f"It needs {' and '.join(lacking)}.")
        if metric is formulas.JOINT_GAP:
            joint_runs = _last_stage(found["joint"], scored)
            return joint_gap(over_runs(formulas.FINAL, all_runs), over_runs(formulas.FINAL, joint_runs))
        if metric.protocols == ("cumulative",):
            return over_runs(metric, _last_stage(found["cumulative"], scored))
        return over_runs(metric, all_runs)

    return {metric.name: value(metric) for metric in formulas.TABLE}


def _last_stage(array: Array, scored: tuple[int, ...]) -> list[formulas.NormalizedRun]:
    """Runs of which nothing but the last stage is known, (runs, T)."""
    T = array.shape[1]
    return [formulas.NormalizedRun(T, scored, {(T, j): float(row[j - 1]) for j in scored}) for row in array]


def _scale(
    floor: ArrayLike | None, expert: ArrayLike | None, tasks: int
) -> tuple[tuple[int, ...], Array, Array]:
    """The positions of the tasks with an expert, the floors, and the experts' heights above them, (T,)."""
    low = np.zeros(tasks) if floor is None else finite("floor", floor)
    high = np.ones(tasks) if expert is None else numbers("expert", expert)
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


def _array(name: str, given: ArrayLike, axes: int) -> Array:
    """A finite array with an axis of runs before its other axes. Raises ``BenchError`` for another one."""
    array = finite(name, given)
    if array.ndim not in (axes, axes + 1) or 0 in array.shape:
        hint = f"Give {axes} axes, or {axes + 1} with the runs first."
        raise BenchError("bad-matrix", f"Its shape is {array.shape}.", name, hint)
    return array.reshape(-1, *array.shape[array.ndim - axes :])
