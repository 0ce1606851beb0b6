"""Ranks that a board can stand by: Welch's test of every pair, Holm's correction, rank intervals."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import combinations

from gym_extensions.scoring.intervals import Summary, combined
from gym_extensions.scoring.student import critical, power, two_sided_p

LEVEL = 0.05
POWER = 0.8
MOST_RUNS = 100
HOPELESS = 1.9
"""A |t| below it has p > .05 at any degrees of freedom, and is not looked up: the normal quantile is 1.96."""


def welch_t(first: Summary, second: Summary) -> tuple[float, float]:
    """Welch's t and its degrees of freedom; ±∞ for different means without variance, 0 for equal means."""
    gap = first.mean - second.mean
    error, freedom = combined([(first.square, first.freedom), (second.square, second.freedom)])
    if gap == 0:
        return 0.0, freedom
    return (gap / error if error > 0 else math.copysign(math.inf, gap)), freedom


def welch_p(first: Summary, second: Summary) -> float:
    """The two-sided p value of Welch's test; 1 where |t| is too small to matter at 5 %."""
    t, freedom = welch_t(first, second)
    return 1.0 if abs(t) < HOPELESS else two_sided_p(t, freedom)


def holm(values: Sequence[float], level: float = LEVEL) -> list[bool]:
    """Which hypotheses Holm's step-down procedure rejects at that family-wise level."""
    order = sorted(range(len(values)), key=lambda index: values[index])
    rejected = [False] * len(values)
    for step, index in enumerate(order):
        if values[index] > level / (len(values) - step):
            break
        rejected[index] = True
    return rejected


def different(entries: Sequence[Summary]) -> set[tuple[int, int]]:
    """The pairs (a, b), a < b, that Welch's test tells apart under Holm's correction over all pairs."""
    pairs = list(combinations(range(len(entries)), 2))
    rejected = holm([welch_p(entries[a], entries[b]) for a, b in pairs])
    return {pair for pair, significant in zip(pairs, rejected, strict=True) if significant}


def rank_intervals(
    entries: Sequence[Summary], pairs: set[tuple[int, int]], better: str
) -> list[tuple[int, int]]:
    """Each entry's first and last possible rank; with 95 % confidence all hold at once.

    From 1 + (entries significantly better) to M − (entries significantly worse), after Mogstad, Romano,
    Shaikh & Wilhelm 2024.

    Args:
        entries: their summaries on one metric.
        pairs: those that are told apart (``different``).
        better: ``higher`` or ``lower``.
    """
    above, below = [0] * len(entries), [0] * len(entries)
    for a, b in pairs:
        first = (entries[a].mean > entries[b].mean) == (better == "higher")
        winner, loser = (a, b) if first else (b, a)
        below[winner] += 1
        above[loser] += 1
    return [(1 + up, len(entries) - down) for up, down in zip(above, below, strict=True)]


def runs_to_separate(gap: float, first: float, second: float, entries: int) -> int | None:
    """The least number of runs each at which two entries would be told apart, or None beyond 100.

    Welch's test at the level .05 / (M(M−1)/2), with 80 % power, if today's means and deviations were the
    truth.

    Args:
        gap: difference of the means.
        first: standard deviation over runs of one entry.
        second: that of the other.
        entries: M, the board's ranked entries.
    """
    level = LEVEL / max(1, entries * (entries - 1) // 2)
    a, b = first * first, second * second
    if gap == 0:
        return None
    if a + b == 0:
        return 2

    def separated(runs: int) -> bool:
        freedom = (runs - 1) * (a + b) ** 2 / (a * a + b * b)
        shift = abs(gap) / math.sqrt((a + b) / runs)
        return power(shift, critical(level, freedom), freedom) >= POWER

    if not separated(MOST_RUNS):
        return None
    low, high = 1, MOST_RUNS
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if separated(middle) else (middle, high)
    return high
