"""One policy update inside the trust region."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gym_extensions.baselines.agent import Array
from gym_extensions.baselines.trpo.gaussian_policy import (
    Batch,
    divergence,
    fisher_product,
    gain,
    log_density,
    mean_and_log_sigma,
    surrogate_gradient,
)
from gym_extensions.baselines.trpo.mlp import Sizes
from gym_extensions.baselines.trpo.optimize import conjugate_gradient, dot, line_search


@dataclass(frozen=True)
class TrustRegion:
    """The paper's numbers: largest mean KL of an update, regularisation and length of conjugate gradient."""

    max_kl: float = 0.01
    damping: float = 1e-5
    iterations: int = 10
    curvature_states: int = 5_000
    """About so many states, spread evenly over a batch of twice as many or more, give the Fisher matrix."""


def updated(sizes: Sizes, theta: Array, batch: Batch, region: TrustRegion) -> Array:
    """Parameters of higher surrogate whose mean KL from the old is at most ``max_kl``; else the old."""
    slope = surrogate_gradient(sizes, theta, batch)
    stride = max(1, len(batch.observations) // region.curvature_states)
    product = fisher_product(sizes, theta, np.ascontiguousarray(batch.observations[::stride]), region.damping)
    direction = conjugate_gradient(product, slope, region.iterations)
    length = dot(direction, product(direction))
    if not (np.isfinite(length) and length > 0):
        return theta
    full_step = theta.dtype.type(np.sqrt(2 * region.max_kl / length)) * direction

    old_mean, old_log_sigma = mean_and_log_sigma(sizes, theta, batch.observations)
    old = log_density(old_mean, old_log_sigma, batch.actions)
    before = gain(old_mean, old_log_sigma, batch, old)

    def accepts(candidate: Array) -> bool:
        mean, log_sigma = mean_and_log_sigma(sizes, candidate, batch.observations)
        apart = divergence(old_mean, old_log_sigma, mean, log_sigma)
        gained = gain(mean, log_sigma, batch, old)
        return bool(np.isfinite(gained) and gained > before and apart <= region.max_kl)

    return line_search(accepts, theta, full_step)[0]
