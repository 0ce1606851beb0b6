"""The area under a training curve: how fast a task was learned."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

from gym_extensions.catalog.protocol import CURVE_POINTS


def area(points: Sequence[tuple[float, float]], end: float) -> float | None:
    """(1/D) ∫₀ᴰ of a curve by trapezoids, held flat before its first and after its last point.

    Args:
        points: (step, value), steps growing; a part beyond ``end`` is cut off there.
        end: D, the budget's training steps.

    Returns:
        The mean height, or None with fewer than ten points.
    """
    if len(points) < CURVE_POINTS:
        return None
    held = [(0.0, points[0][1]), *((float(step), value) for step, value in points)]
    held.append((max(float(end), held[-1][0]), held[-1][1]))
    return math.fsum(_trapezoid(before, after, end) for before, after in pairwise(held)) / end


def _trapezoid(before: tuple[float, float], after: tuple[float, float], end: float) -> float:
    (x0, y0), (x1, y1) = before, after
    if x0 >= end or x1 <= x0:
        return 0.0
    if x1 > end:
        x1, y1 = end, y0 + (y1 - y0) * (end - x0) / (x1 - x0)
    return (x1 - x0) * (y0 + y1) / 2
