"""Mean and standard deviation, summed exactly."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

Number = float | None


def mean(values: Iterable[float]) -> Number:
    """The mean by ``math.fsum``, or None for an empty input. It is never 0 instead."""
    numbers = list(values)
    return math.fsum(numbers) / len(numbers) if numbers else None


def standard_deviation(values: Sequence[float], ddof: int = 0, center: float | None = None) -> float:
    """The standard deviation with divisor n − ``ddof``, as in ``numpy.std``.

    Args:
        values: at least ``ddof`` + 1 numbers.
        ddof: 0 for the population of these values, 1 for a sample.
        center: the mean of the values; computed if None.
    """
    center = math.fsum(values) / len(values) if center is None else center
    residuals = [value - center for value in values]
    return math.sqrt(math.fsum([r * r for r in residuals]) / (len(values) - ddof))
