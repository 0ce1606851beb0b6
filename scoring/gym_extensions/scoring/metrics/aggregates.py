"""How scores spread over runs and tasks: performance profile and interquartile mean (Agarwal et al. 2021)."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence

from gym_extensions.scoring.statistics.descriptive import Number, mean

THRESHOLDS = tuple(step / 20 for step in range(-10, 41))
"""τ from −.5 to 2 by .05."""


def profile(last: Sequence[Sequence[float]]) -> dict[str, list[float]] | None:
    """For each τ the fraction of (run, task) pairs with p[T][j] > τ; None without a pair."""
    values = sorted(value for run in last for value in run)
    if not values:
        return None
    above = [(len(values) - bisect_right(values, threshold)) / len(values) for threshold in THRESHOLDS]
    return {"tau": list(THRESHOLDS), "fraction": above}


def iqm(last: Sequence[Sequence[float]]) -> Number:
    """Mean of the values p[T][j] of all runs and tasks without the lowest and highest ⌊n/4⌋."""
    values = sorted(value for run in last for value in run)
    cut = len(values) // 4
    return mean(values[cut : len(values) - cut])
