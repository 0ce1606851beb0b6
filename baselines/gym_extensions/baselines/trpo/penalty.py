"""A penalty on the parameters inside a TRPO update: its step maximizes surrogate − penalty.

With g the gradient of surrogate − penalty, H the penalty's curvature, F the damped Fisher matrix and δ the
largest KL, the step s of an update is meant to

    maximize gᵀs − ½ sᵀHs  subject to  ½ sᵀFs ≤ δ.

Its solution is s = (H + βF)⁻¹ g for a multiplier β ≥ 0. Without a penalty β = √(gᵀF⁻¹g / 2δ), which makes s
the step of plain TRPO. :func:`penalized_step` takes this β, which needs a second conjugate gradient and no
search: the direction is d = (F + H/β)⁻¹ g, and the step is the best multiple of d within the trust region. A
parameter with a large curvature then makes a small step, instead of one that the line search has to reject.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from gym_extensions.baselines.agent import Array
from gym_extensions.baselines.trpo.optimize import conjugate_gradient, dot

Product = Callable[[Array], Array]
"""A matrix as the map v → A v of flat vectors."""


@dataclass(frozen=True)
class Curvature:
    """A positive semidefinite approximation of a penalty's second derivative.

    Args:
        product: the map v → H v.
        diagonal: the diagonal of H (p,) if H is diagonal, which preconditions the conjugate gradient; or 0.
    """

    product: Product
    diagonal: Array | float = 0.0


class Penalty(Protocol):
    """A function of the policy's flat parameters (p,) that an update subtracts from the surrogate."""

    def value(self, theta: Array) -> float:
        """The penalty, at least 0."""

    def gradient(self, theta: Array) -> Array:
        """Its gradient (p,)."""

    def curvature(self, theta: Array) -> Curvature:
        """Its second derivative, or an approximation of it."""


def natural_step(product: Product, slope: Array, max_kl: float, iterations: int) -> Array | None:
    """The step without a penalty, √(2δ / gᵀF⁻¹g) F⁻¹g (Schulman et al. 2015), or None if it is not finite."""
    direction = conjugate_gradient(product, slope, iterations)
    length = dot(direction, product(direction))
    if not (np.isfinite(length) and length > 0):
        return None
    step: Array = slope.dtype.type(np.sqrt(2 * max_kl / length)) * direction
    return step


def penalized_step(
    product: Product, slope: Array, curvature: Curvature, *, max_kl: float, damping: float, iterations: int
) -> Array | None:
    """The step of an update with a penalty, or None if it is not finite or not uphill.

    Args:
        product: the map v → (F + damping · I) v.
        slope: gradient of surrogate − penalty (p,).
        curvature: of the penalty.
        max_kl: δ.
        damping: of F; it scales the preconditioner.
        iterations: conjugate-gradient iterations of each of the two solutions.
    """
    natural = conjugate_gradient(product, slope, iterations)
    length = dot(natural, product(natural))
    if not (np.isfinite(length) and length > 0):
        return None
    inverse = slope.dtype.type(1 / np.sqrt(length / (2 * max_kl)))
    # Jacobi preconditioning: the diagonal damping + H/β becomes damping, as without a penalty.
    scale = np.sqrt(damping / (damping + inverse * np.asarray(curvature.diagonal))).astype(slope.dtype)

    def combined(vector: Array) -> Array:
        scaled = scale * vector
        image: Array = scale * (product(scaled) + inverse * curvature.product(scaled))
        return image

    direction = scale * conjugate_gradient(combined, scale * slope, iterations)
    uphill = dot(slope, direction)
    length, bend = dot(direction, product(direction)), dot(direction, curvature.product(direction))
    if not (np.isfinite(length) and length > 0 and uphill > 0):
        return None
    size = np.sqrt(2 * max_kl / length)
    if bend > 0:
        size = min(size, uphill / bend)
    step: Array = slope.dtype.type(size) * direction
    return step
