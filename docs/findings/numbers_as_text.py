"""Numbers of the pages as text."""

from __future__ import annotations

from gym_extensions.scoring.statistics.intervals import Interval


def fixed(value: float, digits: int = 2) -> str:
    """A fixed number of decimals and a minus sign."""
    return f"{value + 0.0:,.{digits}f}".replace("-", "−")


def mean(each: Interval, digits: int = 2) -> str:
    """A mean with its interval."""
    return (
        f"{fixed(each.mean, digits)} ({fixed(each.low or 0.0, digits)} to {fixed(each.high or 0.0, digits)})"
    )
