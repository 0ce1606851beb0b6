"""The paper's Gaussian policy: a tanh mean, a log-σ that no state moves; actions in the scale of [−1, 1].

Parameters are one flat vector: the network's, then log σ. Every function is pure.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from gym_extensions.baselines.agent import Array
from gym_extensions.baselines.trpo.mlp import Sizes, forward, gradient, initial, layers, slopes, tangent

BLOCK = 8192
"""Rows of a large batch that go through the network together: their activations stay in the cache."""


@dataclass(frozen=True)
class Batch:
    """What an update sees of n transitions: observations (n, o), raw actions (n, a), advantages (n,)."""

    observations: Array
    actions: Array
    advantages: Array


def initial_policy(sizes: Sizes, rng: np.random.Generator, last_scale: float) -> Array:
    """A flat vector whose log σ is 0."""
    return np.concatenate([initial(sizes, rng, last_scale), np.zeros(sizes[-1], np.float32)])


def mean_and_log_sigma(sizes: Sizes, theta: Array, observations: Array) -> tuple[Array, Array]:
    """Means (n, a) and log σ (a,)."""
    views = layers(sizes, theta)
    parts = [forward(views, observations[rows])[-1] for rows in blocks(len(observations))]
    output = parts[0] if len(parts) == 1 else np.concatenate(parts)
    return np.tanh(output, out=output), theta[-sizes[-1] :]


def blocks(rows: int) -> list[slice]:
    """The rows in pieces of at most ``BLOCK``."""
    return [slice(at, at + BLOCK) for at in range(0, rows, BLOCK)]


def log_density(mean: Array, log_sigma: Array, actions: Array) -> Array:
    """Log density of the actions (n,), without the constant −a/2 · log 2π."""
    scaled = (actions - mean) * np.exp(-log_sigma)
    found: Array = -0.5 * np.einsum("na,na->n", scaled, scaled) - log_sigma.sum()
    return found


def gain(mean: Array, log_sigma: Array, batch: Batch, old_log_density: Array) -> float:
    """The surrogate of a policy of which the means are known."""
    ratio = np.exp(log_density(mean, log_sigma, batch.actions) - old_log_density)
    return float(np.mean(ratio * batch.advantages, dtype=np.float64))


def surrogate(sizes: Sizes, theta: Array, batch: Batch, old_log_density: Array) -> float:
    """Mean of new / old density × advantage, which an update raises (Schulman et al. 2015, eq. 14)."""
    return gain(*mean_and_log_sigma(sizes, theta, batch.observations), batch, old_log_density)


def divergence(old_mean: Array, old_log_sigma: Array, mean: Array, log_sigma: Array) -> float:
    """Mean KL(old ‖ new) over the states."""
    inverse = np.exp(-2 * log_sigma)
    gap = np.mean((mean - old_mean) ** 2, axis=0, dtype=np.float64)
    each = log_sigma - old_log_sigma + 0.5 * (np.exp(2 * old_log_sigma) + gap) * inverse - 0.5
    return float(np.sum(each, dtype=np.float64))


def surrogate_gradient(sizes: Sizes, theta: Array, batch: Batch) -> Array:
    """Gradient of the surrogate where new = old, flat."""
    parts = [_gradient_of(sizes, theta, batch, rows) for rows in blocks(len(batch.observations))]
    return parts[0] if len(parts) == 1 else np.sum(parts, axis=0)


def _gradient_of(sizes: Sizes, theta: Array, batch: Batch, rows: slice) -> Array:
    views = layers(sizes, theta)
    values = forward(views, batch.observations[rows])
    mean, log_sigma = np.tanh(values[-1]), theta[-sizes[-1] :]
    scaled = (batch.actions[rows] - mean) * np.exp(-log_sigma)
    weighted = batch.advantages[rows, None] / len(batch.observations)
    upstream = weighted * scaled * np.exp(-log_sigma) * (1 - mean * mean)
    spread = np.sum(weighted * (scaled * scaled - 1), axis=0)
    return np.concatenate([gradient(views, values, slopes(values), upstream), spread])


def fisher_product(
    sizes: Sizes, theta: Array, observations: Array, damping: float
) -> Callable[[Array], Array]:
    """The map v → (F + damping · I) v, F the Fisher matrix of the policy over the states.

    Exact: for a Gaussian, F = Jᵀ diag(1/σ²) J over the means, and 2 I over log σ.
    """
    views = layers(sizes, theta)
    values = forward(views, observations)
    gates, bend = slopes(values), 1 - np.tanh(values[-1]) ** 2
    outputs = sizes[-1]
    metric = bend * bend * np.exp(-2 * theta[-outputs:]) / len(observations)

    def product(vector: Array) -> Array:
        upstream = tangent(views, values, gates, layers(sizes, vector)) * metric
        curved = np.concatenate([gradient(views, values, gates, upstream), 2 * vector[-outputs:]])
        return curved + damping * vector

    return product
