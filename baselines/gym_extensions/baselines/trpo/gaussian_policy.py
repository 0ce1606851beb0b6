"""A Gaussian policy with a state-independent log σ; actions are in the scale of [−1, 1].

The parameters are one flat vector: those of the network that computes the mean, then log σ. Every function is
pure.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from gym_extensions.baselines.agent import Array
from gym_extensions.baselines.trpo.mlp import (
    ACTIVATIONS,
    Sizes,
    forward,
    gradient,
    initial,
    layers,
    slopes,
    tangent,
)

BLOCK = 8192
"""Rows of a large batch that go through the network together, so that their activations fit in the cache."""


@dataclass(frozen=True)
class Architecture:
    """The network of the mean.

    Args:
        sizes: width of every layer, from observation to action.
        activation: name of the hidden activation, a key of ``ACTIVATIONS``.
        tanh_mean: whether the mean is the tanh of the network's output, or the output.
    """

    sizes: Sizes
    activation: str = "tanh"
    tanh_mean: bool = False


@dataclass(frozen=True)
class Batch:
    """The input of an update: observations (n, o), actions before clipping (n, a) and advantages (n,)."""

    observations: Array
    actions: Array
    advantages: Array


def initial_policy(
    architecture: Architecture, rng: np.random.Generator, last_scale: float, log_sigma: float = 0.0
) -> Array:
    """A flat vector of random weights and the initial ``log_sigma``, float32."""
    sizes = architecture.sizes
    return np.concatenate([initial(sizes, rng, last_scale), np.full(sizes[-1], log_sigma, np.float32)])


def mean_and_log_sigma(architecture: Architecture, theta: Array, observations: Array) -> tuple[Array, Array]:
    """Means (n, a) and log σ (a,)."""
    sizes, activation = architecture.sizes, ACTIVATIONS[architecture.activation]
    views = layers(sizes, theta)
    parts = [forward(views, observations[rows], activation)[-1] for rows in blocks(len(observations))]
    output = parts[0] if len(parts) == 1 else np.concatenate(parts)
    return np.tanh(output, out=output) if architecture.tanh_mean else output, theta[-sizes[-1] :]


def sampled(mean: Array, log_sigma: Array, generator: np.random.Generator) -> Array:
    """Actions (n, a) of a Gaussian with means (n, a) and log σ (a,)."""
    actions: Array = mean + np.exp(log_sigma) * generator.standard_normal(mean.shape, np.float32)
    return actions


def blocks(rows: int) -> list[slice]:
    """Slices of at most ``BLOCK`` rows."""
    return [slice(start, start + BLOCK) for start in range(0, rows, BLOCK)]


def log_density(mean: Array, log_sigma: Array, actions: Array) -> Array:
    """Log density of the actions (n,), without the constant −a/2 · log 2π."""
    scaled = (actions - mean) * np.exp(-log_sigma)
    density: Array = -0.5 * np.einsum("na,na->n", scaled, scaled) - log_sigma.sum()
    return density


def gain(mean: Array, log_sigma: Array, batch: Batch, old_log_density: Array) -> float:
    """The surrogate of a policy with the given means (n, a) and log σ (a,)."""
    ratio = np.exp(log_density(mean, log_sigma, batch.actions) - old_log_density)
    return float(np.mean(ratio * batch.advantages, dtype=np.float64))


def surrogate(architecture: Architecture, theta: Array, batch: Batch, old_log_density: Array) -> float:
    """Mean of new / old density × advantage, which an update raises (Schulman et al. 2015, eq. 14)."""
    return gain(*mean_and_log_sigma(architecture, theta, batch.observations), batch, old_log_density)


def divergence(old_mean: Array, old_log_sigma: Array, mean: Array, log_sigma: Array) -> float:
    """Mean KL(old ‖ new) over the states."""
    inverse = np.exp(-2 * log_sigma)
    gap = np.mean((mean - old_mean) ** 2, axis=0, dtype=np.float64)
    terms = log_sigma - old_log_sigma + 0.5 * (np.exp(2 * old_log_sigma) + gap) * inverse - 0.5
    return float(np.sum(terms, dtype=np.float64))


def surrogate_gradient(architecture: Architecture, theta: Array, batch: Batch) -> Array:
    """Gradient of the surrogate at new = old, flat."""
    parts = [_gradient_of(architecture, theta, batch, rows) for rows in blocks(len(batch.observations))]
    return parts[0] if len(parts) == 1 else np.sum(parts, axis=0)


def _gradient_of(architecture: Architecture, theta: Array, batch: Batch, rows: slice) -> Array:
    activation, views = ACTIVATIONS[architecture.activation], layers(architecture.sizes, theta)
    values = forward(views, batch.observations[rows], activation)
    log_sigma = theta[-architecture.sizes[-1] :]
    mean = np.tanh(values[-1]) if architecture.tanh_mean else values[-1]
    scaled = (batch.actions[rows] - mean) * np.exp(-log_sigma)
    weighted = batch.advantages[rows, None] / len(batch.observations)
    upstream = weighted * scaled * np.exp(-log_sigma)
    if architecture.tanh_mean:
        upstream = upstream * (1 - mean * mean)
    sigma_part = np.sum(weighted * (scaled * scaled - 1), axis=0)
    return np.concatenate([gradient(views, values, slopes(values, activation), upstream), sigma_part])


def fisher_product(
    architecture: Architecture, theta: Array, observations: Array, damping: float
) -> Callable[[Array], Array]:
    """The map v → (F + damping · I) v, with F the Fisher matrix of the policy over the states.

    It is exact. For a Gaussian, F = Jᵀ diag(1/σ²) J over the means, and 2 I over log σ.
    """
    sizes, activation = architecture.sizes, ACTIVATIONS[architecture.activation]
    views = layers(sizes, theta)
    values = forward(views, observations, activation)
    hidden_slopes, outputs = slopes(values, activation), sizes[-1]
    precision = np.exp(-2 * theta[-outputs:])
    if architecture.tanh_mean:
        mean_slope = 1 - np.tanh(values[-1]) ** 2
        metric = mean_slope * mean_slope * precision / len(observations)
    else:
        metric = precision / len(observations)

    def product(vector: Array) -> Array:
        upstream = tangent(views, values, hidden_slopes, layers(sizes, vector)) * metric
        curved = np.concatenate([gradient(views, values, hidden_slopes, upstream), 2 * vector[-outputs:]])
        return curved + damping * vector

    return product
