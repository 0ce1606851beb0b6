"""Mean and standard deviation."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

Number = float | None


def mean(values: Iterable[float]) -> Number:
    """The mean by ``math.fsum``; None of nothing, never 0."""
    listed = list(values)
    return math.fsum(listed) / len(listed) if listed else None


def deviation(values: Sequence[float], lost: int = 0, centre: float | None = None) -> float:
    """The standard deviation, dividing by n − ``lost`` (0: of these episodes, 1: of runs as a sample).

    ``centre`` is the values' mean, where it is known already.
    """
    centre = math.fsum(values) / len(values) if centre is None else centre
    gaps = [value - centre for value in values]
    return math.sqrt(math.fsum([gap * gap for gap in gaps]) / (len(values) - lost))
