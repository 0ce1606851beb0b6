"""Values of metrics and ties as short texts."""

from __future__ import annotations

from gym_extensions.scoring.metrics.value import MetricValue
from gym_extensions.site.text.numbers import fixed


def half_width(value: MetricValue) -> float | None:
    """Half of the interval, which is symmetric; None with fewer than two runs."""
    return (value.ends[1] - value.ends[0]) / 2 if value.ends else None


def plus_minus(value: MetricValue) -> str:
    """Mean and half of the interval with three digits: ``0.421 ±0.113``; empty without a value."""
    half = half_width(value)
    return (
        ""
        if value.mean is None
        else fixed(value.mean, 3) + (f" ±{fixed(half, 3)}" if half is not None else "")
    )


def tied(others: int) -> str:
    """With how many other entries an entry is tied, or nothing."""
    return f"tied with {others} other{'' if others == 1 else 's'}" if others else ""
