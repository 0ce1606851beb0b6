"""One policy update inside the trust region, with an optional penalty on the parameters.

With g the gradient of surrogate − penalty, H the penalty's curvature, F the damped Fisher matrix and δ the
largest KL, the step s of an update is meant to

    maximize gᵀs − ½ sᵀHs  subject to  ½ sᵀFs ≤ δ.

Its solution is s = (H + βF)⁻¹ g for a multiplier β ≥ 0. Without a penalty β = √(gᵀF⁻¹g / 2δ), which makes s
the step of plain TRPO. :func:`step_within` takes this β, which needs a second conjugate gradient and no
search: the direction is d = (F + H/β)⁻¹ g, and the step is the best multiple of d within the trust region. A
parameter with a large curvature then makes a small step, instead of one that the line search has to reject.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from gym_extensions.baselines.agent import Array
from gym_extensions.baselines.trust_region import policy

SHRINK, STEPS_TRIED = 0.8, 15
"""The line search multiplies a step by the first until it is accepted, at most so often."""


def dot(left: Array, right: Array) -> float:
    """The inner product, summed in float64."""
    return float(np.dot(left.astype(np.float64, copy=False), right.astype(np.float64, copy=False)))


Product = Callable[[Array], Array]
"""A matrix as the map v → A v of flat vectors."""


def conjugate_gradient(product: Product, target: Array, iterations: int) -> tuple[Array, Array]:
    """Solves A x ≈ target from x = 0 for the positive-definite A of a product; returns x and A x."""
    solution = np.zeros_like(target)
    residual, direction = target.copy(), target.copy()
    squared = dot(residual, residual)
    for _ in range(iterations):
        if squared < 1e-10:
            break
        image = product(direction)
        step = target.dtype.type(squared / dot(direction, image))
        solution += step * direction
        residual -= step * image
        before, squared = squared, dot(residual, residual)
        direction = residual + target.dtype.type(squared / before) * direction
    return solution, target - residual


@dataclass(frozen=True)
class Curvature:
    """A positive semidefinite approximation of a penalty's second derivative."""

    product: Product  # the map v → H v
    diagonal: Array | float = 0.0  # of H (p,) if H is diagonal: preconditions the conjugate gradient; or 0


class Penalty(Protocol):
    """A function of the policy's flat parameters (p,) that an update subtracts from the surrogate."""

    def value(self, theta: Array) -> float:
        """The penalty, at least 0."""

    def gradient(self, theta: Array) -> Array:
        """Its gradient (p,)."""

    def curvature(self, theta: Array) -> Curvature:
        """Its second derivative, or an approximation of it."""


@dataclass(frozen=True)
class TrustRegion:
    """Limits of an update.

    From twice ``curvature_states`` states n on, the Fisher matrix is an average over a part of the batch:
    every k-th state, with k = n // curvature_states.
    """

    max_kl: float  # largest mean KL(old ‖ new) over the states, in nats, summed over the action's components
    damping: float  # multiple of the identity that is added to the Fisher matrix
    iterations: int = 10  # of each conjugate gradient
    curvature_states: int = 5_000
    least_log_sigma: float = -math.inf  # lower bound of every component of log σ


def step_within(
    region: TrustRegion, product: Product, slope: Array, curvature: Curvature | None = None
) -> Array | None:
    """The step of an update, or None if it is not finite or not uphill.

    Without a penalty it is √(2δ / gᵀF⁻¹g) F⁻¹g (Schulman et al. 2015). ``product`` is the map
    v → (F + damping · I) v, ``slope`` (p,) the gradient of surrogate − penalty.
    """
    direction, image = conjugate_gradient(product, slope, region.iterations)
    length = dot(direction, image)
    if not (np.isfinite(length) and length > 0):
        return None
    size = np.sqrt(2 * region.max_kl / length)
    if curvature is not None:
        inverse = slope.dtype.type(1 / np.sqrt(length / (2 * region.max_kl)))
        # Jacobi preconditioning: the diagonal damping + H/β becomes damping, as without a penalty.
        diagonal = region.damping + inverse * np.asarray(curvature.diagonal)
        scale, bent = np.sqrt(region.damping / diagonal).astype(slope.dtype), curvature.product

        def combined(vector: Array) -> Array:
            scaled = scale * vector
            return scale * (product(scaled) + inverse * bent(scaled))

        direction = scale * conjugate_gradient(combined, scale * slope, region.iterations)[0]
        uphill, bend = dot(slope, direction), dot(direction, bent(direction))
        length = dot(direction, product(direction))
        if not (np.isfinite(length) and length > 0 and uphill > 0):
            return None
        size = np.sqrt(2 * region.max_kl / length)
        if bend > 0:
            size = min(size, uphill / bend)
    return slope.dtype.type(size) * direction


def updated(
    architecture: policy.Architecture,
    theta: Array,
    batch: policy.Batch,
    region: TrustRegion,
    *,
    penalty: Penalty | None = None,
    trainable: Array | None = None,
) -> Array:
    """Parameters with a higher surrogate within ``max_kl`` of the old ones (p,), or the old ones if none do.

    The penalty is subtracted from the surrogate. ``trainable`` (p,) is 1 for parameters that may change, 0
    for others; by default all may change.
    """
    values = policy.forward(architecture, theta, batch.observations)
    slope = policy.surrogate_gradient(architecture, theta, batch, values)
    stride = max(1, len(batch.observations) // region.curvature_states)
    part = tuple(np.ascontiguousarray(each[::stride]) for each in values)
    product = policy.fisher_product(architecture, theta, part, region.damping)
    curvature = None
    if penalty:
        slope, curvature = slope - penalty.gradient(theta), penalty.curvature(theta)
    if trainable is not None:
        slope, product = trainable * slope, _restricted(product, trainable)
    if curvature and trainable is not None:
        curvature = replace(curvature, product=_restricted(curvature.product, trainable))
    sigmas = architecture.log_sigmas
    slope[sigmas][(theta[sigmas] <= region.least_log_sigma) & (slope[sigmas] < 0)] = 0
    full_step = step_within(region, product, slope, curvature)
    if full_step is None:
        return theta

    old_mean, old_log_sigma = policy.means(architecture, values[-1]), theta[sigmas]
    old = policy.log_density(old_mean, old_log_sigma, batch.actions)

    def objective(parameters: Array, mean: Array, log_sigma: Array) -> float:
        surrogate = policy.surrogate(mean, log_sigma, batch, old)
        return surrogate - penalty.value(parameters) if penalty else surrogate

    before = objective(theta, old_mean, old_log_sigma)
    for number in range(STEPS_TRIED):
        candidate: Array = theta + theta.dtype.type(SHRINK**number) * full_step
        np.maximum(candidate[sigmas], region.least_log_sigma, out=candidate[sigmas])
        mean, log_sigma = policy.mean_and_log_sigma(architecture, candidate, batch.observations)
        kl = policy.mean_kl(old_mean, old_log_sigma, mean, log_sigma)
        after = objective(candidate, mean, log_sigma)
        if np.isfinite(after) and after > before and kl <= region.max_kl:
            return candidate
    return theta


def _restricted(product: Product, trainable: Array) -> Product:
    return lambda vector: trainable * product(vector)
