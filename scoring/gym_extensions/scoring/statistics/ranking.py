"""Ranks that a board can stand by: Welch's test of every pair, Holm's correction, rank intervals."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

from gym_extensions.scoring.statistics.intervals import Summary
from gym_extensions.scoring.statistics.student_t import critical, power
from gym_extensions.scoring.statistics.welch import CLOSE, Column, pairs

LEVEL = 0.05
POWER = 0.8
MOST_RUNS = 100
MARGIN = 1e-6
"""What the normal distribution of the standard library may err by, and more."""

Apart = NDArray[np.bool_]
"""Which entries are told apart: a symmetric matrix of truths."""


def holm(values: Column, exact: Callable[..., float], level: float = LEVEL) -> NDArray[np.bool_]:
    """Which hypotheses Holm's step-down procedure rejects at that family-wise level.

    Args:
        values: p values, good to much less than ``CLOSE`` of themselves, in an array of any shape; what is
            above 1 is no hypothesis.
        exact: the p value of the hypothesis with these indices, asked for where it is close to its limit.
        level: of the family-wise error.
    """
    ordered = np.sort(values, axis=None)[: np.count_nonzero(values <= 1)]
    limits = level / (ordered.size - np.arange(ordered.size))
    close = ordered[np.abs(ordered - limits) <= CLOSE * limits]
    if close.size:
        values = values.copy()
        for place in np.argwhere(np.isin(values, close)).tolist():
            values[tuple(place)] = exact(*place)
        ordered = np.sort(values, axis=None)[: ordered.size]
    beyond = np.flatnonzero(ordered > limits)
    last = beyond[0] if beyond.size else ordered.size
    rejected: NDArray[np.bool_] = values <= (ordered[last - 1] if last else -1.0)
    return rejected


def different(entries: Sequence[Summary]) -> Apart:
    """The pairs [a, b] that Welch's test tells apart under Holm's correction over all pairs."""
    found = pairs(entries)
    apart = holm(found.quick(LEVEL), found.exact)
    return apart | apart.T


def rank_intervals(entries: Sequence[Summary], apart: Apart, better: str) -> list[tuple[int, int]]:
    """Each entry's first and last possible rank; with 95 % confidence all hold at once.

    From 1 + (entries significantly better) to M − (entries significantly worse), after Mogstad, Romano,
    Shaikh & Wilhelm 2024.

    Args:
        entries: their summaries on one metric.
        apart: those that are told apart (``different``).
        better: ``higher`` or ``lower``.
    """
    mean = np.array([entry.mean for entry in entries])
    loses = mean[:, None] < mean if better == "higher" else mean[:, None] > mean
    above, below = (apart & loses).sum(axis=1).tolist(), (apart & loses.T).sum(axis=1).tolist()
    return [(1 + up, len(entries) - down) for up, down in zip(above, below, strict=True)]


def _least_shift(level: float) -> float:
    """A smaller shift is not seen with that power even where deviations are known (by the normal test)."""
    normal = NormalDist()
    return -normal.inv_cdf(level / 2) + normal.inv_cdf(POWER - level / 2) - MARGIN


def runs_to_separate(between: Summary, entries: int) -> int | None:
    """The least number of runs each at which two entries would be told apart, or None beyond 100.

    Welch's test at the level .05 / (M(M−1)/2), with 80 % power, if today's means and deviations were the
    truth. On a suite that is so many runs of every group, each with its own deviation.

    Args:
        between: the summary of their difference (``intervals.less``), each having two runs or more.
        entries: M, the board's ranked entries.
    """
    level = LEVEL / max(1, entries * (entries - 1) // 2)
    if between.mean == 0:
        return None
    if between.variance == 0:
        return 2
    least = _least_shift(level)

    def separated(runs: int) -> bool:
        freedom = (runs - 1) * between.groups
        shift = abs(between.mean) / math.sqrt(between.variance / runs)
        if shift < least:
            return False
        return power(shift, critical(level, freedom), freedom) >= POWER

    if not separated(MOST_RUNS):
        return None
    low, high = 1, MOST_RUNS
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if separated(middle) else (middle, high)
    return high
