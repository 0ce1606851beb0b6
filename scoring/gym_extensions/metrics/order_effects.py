"""How much of a score is due to its task, and how much to the position of the task in the order of training.

The runs fill balanced squares: every task is equally often in every position. So the effects of task and
position are orthogonal, and means are their least-squares estimates. See docs/metrics.md, "Order".
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np

from gym_extensions.catalog.protocol import balanced_square
from gym_extensions.documents import about
from gym_extensions.metrics.formulas import FINAL, FORGETTING, Metric, NormalizedRun
from gym_extensions.metrics.statistics import ratio_of_groups, summary, to_interval
from gym_extensions.metrics.values import Estimate


@dataclass(frozen=True, slots=True)
class OrderEffects:
    """A metric by position and by task over the runs of whole balanced squares.

    What has no value, such as forgetting in the last position, is an estimate without a mean. Intervals are
    over runs. That of a position is Student's of its n values y[r, j] − α_i(r, j), with n − 1 − n (K − 1) / N
    degrees of freedom, for N values in all and K tasks; that of a task likewise. That of a share is of the
    ratio of two means over runs, linearized, with the terms β (2 (y − m − α) − β) and (y − m)².
    """

    position: Annotated[tuple[Estimate, ...], about("mean at each position, over all tasks equally")]
    task: Annotated[tuple[Estimate, ...], about("mean on each task, over all positions equally")]
    shares: Annotated[
        dict[str, Estimate],
        about("of the squared deviations: of `position`, `task` and `rest`; none if all values are equal"),
    ]


def order_effects(runs: Sequence[NormalizedRun]) -> dict[str, OrderEffects]:
    """The effects on final performance and forgetting, by name, over the runs of whole squares.

    ``runs`` are the balanced runs from 0 on. Without a whole square, or a task with a value, there are none.
    """
    rows = [tuple(task + 1 for task in row) for row in balanced_square(runs[0].T)] if runs else [()]
    square = runs[: len(runs) // len(rows) * len(rows)]
    if [run.order for run in square] != rows * (len(square) // len(rows)):  # a run between them is missing
        return {}
    return {each.name: found for each in (FINAL, FORGETTING) if (found := _effects_on(each, square))}


def _effects_on(metric: Metric, runs: Sequence[NormalizedRun]) -> OrderEffects | None:
    assert metric.terms is not None
    terms = [(at, j, run.task(j), value) for at, run in enumerate(runs) for j, value in metric.terms(run)]
    if not terms:
        return None
    run, position, task, values = map(np.array, zip(*terms, strict=True))
    levels, deviations = {"position": position, "task": task}, values - math.fsum(values) / len(values)
    means = {
        name: {each: math.fsum(deviations[of == each]) / (of == each).sum() for each in set(of.tolist())}
        for name, of in levels.items()
    }
    effects = {name: np.array([means[name][each] for each in of.tolist()]) for name, of in levels.items()}
    estimates, squares = {}, {}
    for name, other in (("position", "task"), ("task", "position")):
        adjusted, used = values - effects[other], (len(means[other]) - 1) / len(values)
        estimates[name] = tuple(
            _estimate(adjusted[levels[name] == each].tolist(), used) for each in range(1, runs[0].T + 1)
        )
        # Its sum over all runs is that of the squares of the effects.
        squares[name] = effects[name] * (2 * (deviations - effects[other]) - effects[name])
    squares |= {"rest": deviations**2 - sum(squares.values()), "total": deviations**2}
    per_run = {
        name: [math.fsum(part[run == at]) for at in range(len(runs))] for name, part in squares.items()
    }
    total = per_run.pop("total")
    ratios = {name: ratio_of_groups([(part, total)]) for name, part in per_run.items() if any(total)}
    shares = {name: Estimate(each.mean, each.low, each.high) for name, each in ratios.items()}
    return OrderEffects(**estimates, shares=shares)


def _estimate(values: Sequence[float], used: float) -> Estimate:
    """The mean of one value per run. The estimated other effects use a part of the degrees of freedom.

    ``used`` is that part, per value. There is no interval if less than one is left.
    """
    if not values:
        return Estimate()
    found = summary(values)
    left = found.df - used * len(values)
    if left < 1:
        return Estimate(found.mean)
    value = to_interval(replace(found, squared_error=found.squared_error * found.df / left, df=left))
    return Estimate(value.mean, value.low, value.high)
