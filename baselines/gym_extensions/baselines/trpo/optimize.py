"""The two searches of an update: conjugate gradient for the direction, backtracking for its length."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from gym_extensions.baselines.agent import Array


def dot(left: Array, right: Array) -> float:
    """The inner product, summed in float64."""
    return float(np.dot(left.astype(np.float64, copy=False), right.astype(np.float64, copy=False)))


def conjugate_gradient(
    product: Callable[[Array], Array], target: Array, iterations: int = 10, tolerance: float = 1e-10
) -> Array:
    """Solves A x ≈ target from x = 0, for a positive-definite A that is passed as a product v → A v."""
    solution = np.zeros_like(target)
    residual, direction = target.copy(), target.copy()
    squared = dot(residual, residual)
    for _ in range(iterations):
        if squared < tolerance:
            break
        image = product(direction)
        step = target.dtype.type(squared / dot(direction, image))
        solution += step * direction
        residual -= step * image
        before, squared = squared, dot(residual, residual)
        direction = residual + target.dtype.type(squared / before) * direction
    return solution


def line_search(
    accepts: Callable[[Array], bool], start: Array, full_step: Array, shrink: float = 0.8, tries: int = 15
) -> tuple[Array, int]:
    """The first accepted start + full_step × shrinkᵏ, and k; if none is accepted, the start and ``tries``."""
    for number in range(tries):
        candidate = start + start.dtype.type(shrink**number) * full_step
        if accepts(candidate):
            return candidate, number
    return start, tries
