"""Means with their intervals as text."""

from __future__ import annotations

from gym_extensions.scoring.statistics import Interval
from gym_extensions.site.text import fixed, interval


def mean(each: Interval, digits: int = 2) -> str:
    """A mean with its interval, which one run does not have."""
    if each.low is None or each.high is None:
        return f"{fixed(each.mean, digits)} (one run)"
    return f"{fixed(each.mean, digits)} ({interval(each.low, each.high, digits)})"
