"""Rank intervals of a board, and the number of runs that would separate two entries."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Sequence

import numpy as np

from gym_extensions.catalog.protocol import FULL_ENTRY_RUNS
from gym_extensions.scoring.statistics.intervals import Summary
from gym_extensions.scoring.statistics.student_t import critical_value, power
from gym_extensions.scoring.statistics.welch import ALPHA, Mask

POWER = 0.8
MAX_RUNS = 100


def rank_intervals(entries: Sequence[Summary], significant: Mask, better: str) -> list[tuple[int, int]]:
    """The first and last possible rank of each entry.

    They are 1 + (number of significantly better entries) and M − (number of significantly worse entries).
    With 95 % confidence, all of them hold simultaneously (Mogstad, Romano, Shaikh & Wilhelm 2024).

    Args:
        entries: M summaries of one metric.
        significant: M × M, from ``welch.significant_pairs``.
        better: ``higher`` or ``lower``.
    """
    mean = np.array([entry.mean for entry in entries])
    loses = mean[:, None] < mean if better == "higher" else mean[:, None] > mean
    losses = (significant & loses).sum(axis=1).tolist()
    wins = (significant & loses.T).sum(axis=1).tolist()
    return [(1 + above, len(entries) - below) for above, below in zip(losses, wins, strict=True)]


def runs_to_separate(between: Summary, entries: int) -> int | None:
    """The smallest number of runs per entry that would separate two entries, or None beyond 100.

    Welch's test at the level .05 / (M(M−1)/2) must have a power of 80 % if the present means and deviations
    are the truth. On a suite it is the number of runs per group, where each group has its own deviation. The
    result is at least 5, the runs of a full entry, because no rank is given below.

    Args:
        between: the difference of the two entries (``intervals.subtract``), each with two runs or more.
        entries: M, the number of ranked entries on the board.
    """
    if between.mean == 0:
        return None
    if between.variance == 0:
        return FULL_ENTRY_RUNS
    alpha = ALPHA / max(1, entries * (entries - 1) // 2)

    def separated(runs: int) -> bool:
        df = (runs - 1) * between.groups
        shift = abs(between.mean) * math.sqrt(runs / between.variance)
        return power(shift, critical_value(alpha, df), df) >= POWER

    candidates = range(FULL_ENTRY_RUNS, MAX_RUNS + 1)
    index = bisect_left(candidates, True, key=separated)
    return candidates[index] if index < len(candidates) else None
