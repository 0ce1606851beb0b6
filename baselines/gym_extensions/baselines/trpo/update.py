"""One policy update inside the trust region."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gym_extensions.baselines.agent import Array
from gym_extensions.baselines.trpo.gaussian_policy import (
    Architecture,
    Batch,
    divergence,
    fisher_product,
    gain,
    log_density,
    mean_and_log_sigma,
    surrogate_gradient,
)
from gym_extensions.baselines.trpo.optimize import conjugate_gradient, dot, line_search


@dataclass(frozen=True)
class TrustRegion:
    """Limits of an update.

    Args:
        max_kl: largest mean KL(old ‖ new) over the states, in nats, summed over the action's components.
        damping: multiple of the identity that is added to the Fisher matrix.
        iterations: conjugate-gradient iterations.
        curvature_states: from this number of states on, the Fisher matrix is an average over a part of the
            batch: every k-th state, with k = n // curvature_states.
    """

    max_kl: float
    damping: float
    iterations: int = 10
    curvature_states: int = 5_000


def updated(architecture: Architecture, theta: Array, batch: Batch, region: TrustRegion) -> Array:
    """Parameters with a higher surrogate within ``max_kl`` of the old ones, or the old ones if none do."""
    slope = surrogate_gradient(architecture, theta, batch)
    stride = max(1, len(batch.observations) // region.curvature_states)
    states = np.ascontiguousarray(batch.observations[::stride])
    product = fisher_product(architecture, theta, states, region.damping)
    direction = conjugate_gradient(product, slope, region.iterations)
    length = dot(direction, product(direction))
    if not (np.isfinite(length) and length > 0):
        return theta
    full_step = theta.dtype.type(np.sqrt(2 * region.max_kl / length)) * direction

    old_mean, old_log_sigma = mean_and_log_sigma(architecture, theta, batch.observations)
    old = log_density(old_mean, old_log_sigma, batch.actions)
    before = gain(old_mean, old_log_sigma, batch, old)

    def accepts(candidate: Array) -> bool:
        mean, log_sigma = mean_and_log_sigma(architecture, candidate, batch.observations)
        kl = divergence(old_mean, old_log_sigma, mean, log_sigma)
        after = gain(mean, log_sigma, batch, old)
        return bool(np.isfinite(after) and after > before and kl <= region.max_kl)

    return line_search(accepts, theta, full_step)[0]
