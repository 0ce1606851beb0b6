"""Area under a training curve, which shows how fast a task was learned."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

from gym_extensions.catalog.protocol import CURVE_POINTS


def area(steps: Sequence[int], values: Sequence[float], end: float) -> float | None:
    """(1/D) ∫₀ᴰ of a curve by trapezoids, constant before its first and after its last point.

    Args:
        steps: training steps of the points, ascending from 1; the curve is cut off at ``end``.
        values: values of the points.
        end: D, the budget's training steps.

    Returns:
        The mean height, or None with fewer than ten points.
    """
    if len(steps) < CURVE_POINTS:
        return None
    points = [(0.0, values[0]), *zip(map(float, steps), values, strict=True)]
    points = [*points, (float(end), values[-1])] if steps[-1] <= end else _cut(points, float(end))
    return math.fsum([(x1 - x0) * (y0 + y1) / 2 for (x0, y0), (x1, y1) in pairwise(points)]) / end


def _cut(points: Sequence[tuple[float, float]], end: float) -> list[tuple[float, float]]:
    """The points before ``end``, and the curve's value at ``end``."""
    beyond = next(index for index, (x, _) in enumerate(points) if x >= end)
    (x0, y0), (x1, y1) = points[beyond - 1], points[beyond]
    return [*points[:beyond], (end, y0 + (y1 - y0) * (end - x0) / (x1 - x0))]
