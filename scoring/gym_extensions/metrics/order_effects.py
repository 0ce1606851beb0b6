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
from gym_extensions.metrics.statistics import Array, ratio_of_groups, summary, to_interval
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
    size = len(balanced_square(runs[0].T)) if runs else 1
    whole = runs[: len(runs) // size * size]
    return {each.name: found for each in (FINAL, FORGETTING) if (found := _effects_on(each, whole))}


def _effects_on(metric: Metric, runs: Sequence[NormalizedRun]) -> OrderEffects | None:
    terms = [(at, j, run.task(j), value) for at, run in enumerate(runs) for j, value in metric.terms(run)]
    if not terms:
        return None
    run, position, task, values = map(np.array, zip(*terms, strict=True))
    deviations = values - math.fsum(values) / len(values)
    estimates, squares = {}, {}
    for name, level, other in (("position", position, task), ("task", task, position)):
        effect, effect_of_other = (_mean_at(each, deviations) for each in (level, other))
        adjusted, used = values - effect_of_other, (len(np.unique(other)) - 1) / len(values)
        estimates[name] = tuple(
            _estimate(adjusted[level == each].tolist(), used) for each in range(1, runs[0].T + 1)
        )
        # Its sum over all runs is that of the squares of the effects.
        squares[name] = effect * (2 * (deviations - effect_of_other) - effect)
    squares["rest"] = deviations**2 - sum(squares.values())

    def per_run(square: Array) -> list[float]:
        return [math.fsum(square[run == at]) for at in range(len(runs))]

    shares, total = {}, per_run(deviations**2)
    if any(total):
        for name, square in squares.items():
            ratio = ratio_of_groups([(per_run(square), total)])
            shares[name] = Estimate(ratio.mean, ratio.low, ratio.high)
    return OrderEffects(**estimates, shares=shares)


def _mean_at(level: Array, values: Array) -> Array:
    """For every value, the mean of the values at its level."""
    return np.array([math.fsum(values[level == each]) / (level == each).sum() for each in level])


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
