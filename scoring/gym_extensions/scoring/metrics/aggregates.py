"""Performance profile and interquartile mean of the scores over runs and tasks.

Both follow Agarwal et al. 2021.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

from gym_extensions.scoring.documents import about
from gym_extensions.scoring.statistics.descriptive import Number, mean

THRESHOLDS = tuple(step / 20 for step in range(-10, 41))
"""τ from −.5 to 2 in steps of .05."""


@dataclass(frozen=True, slots=True)
class Profile:
    """Performance profile: for each τ the fraction of (run, task) pairs with a score above it."""

    tau: Annotated[tuple[float, ...], about("scores τ, ascending")]
    fraction: Annotated[tuple[float, ...], about("for each τ the fraction of pairs with p[T][j] > τ")]

    @property
    def points(self) -> tuple[tuple[float, float], ...]:
        """Pairs (τ, fraction), by τ."""
        return tuple(zip(self.tau, self.fraction, strict=True))


def profile(scores: Sequence[Sequence[float]]) -> Profile | None:
    """The performance profile of scores [run][task], or None without scores."""
    values = sorted(value for run in scores for value in run)
    if not values:
        return None
    above = tuple((len(values) - bisect_right(values, threshold)) / len(values) for threshold in THRESHOLDS)
    return Profile(THRESHOLDS, above)


def iqm(scores: Sequence[Sequence[float]]) -> Number:
    """Mean of the scores [run][task] without the lowest and highest ⌊n/4⌋, or None without scores."""
    values = sorted(value for run in scores for value in run)
    cut = len(values) // 4
    return mean(values[cut : len(values) - cut])
