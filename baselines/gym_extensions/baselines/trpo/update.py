"""One policy update inside the trust region."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

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
from gym_extensions.baselines.trpo.optimize import line_search
from gym_extensions.baselines.trpo.penalty import Penalty, Product, natural_step, penalized_step


@dataclass(frozen=True)
class TrustRegion:
    """Limits of an update.

    Args:
        max_kl: largest mean KL(old ‖ new) over the states, in nats, summed over the action's components.
        damping: multiple of the identity that is added to the Fisher matrix.
        iterations: conjugate-gradient iterations.
        curvature_states: from this number of states on, the Fisher matrix is an average over a part of the
            batch: every k-th state, with k = n // curvature_states.
        least_log_sigma: lower bound of every component of log σ.
    """

    max_kl: float
    damping: float
    iterations: int = 10
    curvature_states: int = 5_000
    least_log_sigma: float = -math.inf


def updated(
    architecture: Architecture,
    theta: Array,
    batch: Batch,
    region: TrustRegion,
    *,
    penalty: Penalty | None = None,
    trainable: Array | None = None,
) -> Array:
    """Parameters with a higher surrogate within ``max_kl`` of the old ones, or the old ones if none do.

    Args:
        architecture: the policy's network.
        theta: the old parameters (p,).
        batch: observations, actions and advantages.
        region: the limits of the update.
        penalty: subtracted from the surrogate.
        trainable: 1 for the parameters that may change, 0 for the others (p,); by default all may.
    """
    slope = surrogate_gradient(architecture, theta, batch)
    stride = max(1, len(batch.observations) // region.curvature_states)
    states = np.ascontiguousarray(batch.observations[::stride])
    product = fisher_product(architecture, theta, states, region.damping)
    if penalty:
        slope = slope - penalty.gradient(theta)
    if trainable is not None:
        slope, product = trainable * slope, _restricted(product, trainable)
    sigmas = slice(len(theta) - architecture.sizes[-1], None)
    slope[sigmas][(theta[sigmas] <= region.least_log_sigma) & (slope[sigmas] < 0)] = 0
    if penalty:
        curvature = penalty.curvature(theta)
        if trainable is not None:
            curvature = replace(curvature, product=_restricted(curvature.product, trainable))
        full_step = penalized_step(
            product,
            slope,
            curvature,
            max_kl=region.max_kl,
            damping=region.damping,
            iterations=region.iterations,
        )
    else:
        full_step = natural_step(product, slope, region.max_kl, region.iterations)
    if full_step is None:
        return theta

    old_mean, old_log_sigma = mean_and_log_sigma(architecture, theta, batch.observations)
    old = log_density(old_mean, old_log_sigma, batch.actions)
    before = gain(old_mean, old_log_sigma, batch, old) - (penalty.value(theta) if penalty else 0.0)

    def bounded(parameters: Array) -> Array:
        within = parameters.copy()
        np.maximum(within[sigmas], region.least_log_sigma, out=within[sigmas])
        return within

    def accepts(step: Array) -> bool:
        candidate = bounded(step)
        mean, log_sigma = mean_and_log_sigma(architecture, candidate, batch.observations)
        kl = divergence(old_mean, old_log_sigma, mean, log_sigma)
        after = gain(mean, log_sigma, batch, old) - (penalty.value(candidate) if penalty else 0.0)
        return bool(np.isfinite(after) and after > before and kl <= region.max_kl)

    return bounded(line_search(accepts, theta, full_step)[0])


def _restricted(product: Product, trainable: Array) -> Product:
    return lambda vector: trainable * product(vector)
