"""The policy of TRPO: a Gaussian whose mean is a multilayer perceptron, with its derivatives."""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from gym_extensions.baselines.agent import Array
from gym_extensions.submissions.policies.mlp import Policy

CLIP = 10.0
"""Standardized observations are clipped to ±10 standard deviations, as by SB3's ``VecNormalize``."""
LEAST_DEVIATION = 1e-3
"""Smallest deviation of a policy's observations, so that rounding errors of constant ones stay small."""
EPSILON = 1e-8
"""Added to the standard deviation."""


@dataclass(frozen=True)
class Moments:
    """Number of observations so far, their mean (o,) and their sum of squared deviations (o,), float64."""

    count: float
    mean: Array
    squares: Array


def no_moments(width: int) -> Moments:
    """The moments of no observations."""
    return Moments(0.0, np.zeros(width), np.zeros(width))


def merge(moments: Moments, observations: Array) -> Moments:
    """The moments with the observations (n, o) added, by the formula of Chan, Golub and LeVeque (1979)."""
    new = observations.astype(np.float64)
    count, seen = len(new), moments.count
    new_mean = new.mean(axis=0)
    gap = new_mean - moments.mean
    inside = np.square(new - new_mean).sum(axis=0)
    between = gap**2 * seen * count / (seen + count)
    mean = moments.mean + gap * count / (seen + count)
    return Moments(seen + count, mean, moments.squares + (inside + between))


def scale(moments: Moments, least: float = LEAST_DEVIATION) -> Array:
    """What observations are divided by (o,): the standard deviation, at least ``least``."""
    deviation = np.sqrt(moments.squares / max(moments.count, 1.0))
    return np.maximum(deviation, least) + EPSILON


def standardize(moments: Moments, observations: Array, least: float = LEAST_DEVIATION) -> Array:
    """Observations (n, o) minus the mean, over the standard deviation, clipped; float32."""
    return np.clip((observations - moments.mean) / scale(moments, least), -CLIP, CLIP).astype(np.float32)


def network_inputs(moments: Moments, observations: Array) -> Array:
    """Standardized observations (n, o); raw ones while the moments are those of no observations."""
    return standardize(moments, observations) if moments.count else observations


Sizes = tuple[int, ...]
"""Width of every layer, input and output included."""
Layers = list[tuple[Array, Array]]
"""Weights (in, out) and bias (out,) of every layer."""


class Activation(NamedTuple):
    """A hidden activation: its value, computed in place, and its derivative as a function of its value."""

    value: Callable[[Array], Array]
    slope: Callable[[Array], Array]


ACTIVATIONS = {
    "relu": Activation(
        lambda inputs: np.maximum(inputs, 0, out=inputs), lambda hidden: (hidden > 0).astype(hidden.dtype)
    ),
    "tanh": Activation(lambda inputs: np.tanh(inputs, out=inputs), lambda hidden: 1 - hidden * hidden),
}
"""Hidden activations by name. The output layer has none."""


def parameter_count(sizes: Sizes) -> int:
    """Number of weights and biases."""
    return sum((fan_in + 1) * fan_out for fan_in, fan_out in pairwise(sizes))


def initial(sizes: Sizes, rng: np.random.Generator, last_scale: float = 1.0) -> Array:
    """He-uniform hidden weights, Glorot-uniform last weights × ``last_scale``, zero biases; flat float32."""
    parts = []
    for layer, (fan_in, fan_out) in enumerate(pairwise(sizes)):
        last = layer == len(sizes) - 2
        bound = last_scale * np.sqrt(6.0 / (fan_in + fan_out)) if last else np.sqrt(6.0 / fan_in)
        parts += [rng.uniform(-bound, bound, fan_in * fan_out), np.zeros(fan_out)]
    return np.concatenate(parts).astype(np.float32)


def layers(sizes: Sizes, theta: Array) -> Layers:
    """Views of the flat vector, one pair per layer."""
    views, start = [], 0
    for fan_in, fan_out in pairwise(sizes):
        end = start + fan_in * fan_out
        views.append((theta[start:end].reshape(fan_in, fan_out), theta[end : end + fan_out]))
        start = end + fan_out
    return views


def forward(views: Layers, inputs: Array, activation: Activation) -> list[Array]:
    """The input, every hidden activation and the output, each (n, width)."""
    values = [inputs]
    for weights, bias in views[:-1]:
        hidden = values[-1] @ weights
        hidden += bias
        values.append(activation.value(hidden))
    weights, bias = views[-1]
    values.append(values[-1] @ weights + bias)
    return values


def tangent(views: Layers, values: list[Array], hidden_slopes: list[Array], direction: Layers) -> Array:
    """Derivative of the output (n, out) along a direction of the parameters."""
    change = np.zeros_like(values[0])
    for layer, ((weights, _), (d_weights, d_bias)) in enumerate(zip(views, direction, strict=True)):
        step = values[layer] @ d_weights
        step += d_bias
        if layer:
            step += change @ weights
        if layer < len(hidden_slopes):
            step *= hidden_slopes[layer]
        change = step
    return change


def gradient(views: Layers, values: list[Array], hidden_slopes: list[Array], upstream: Array) -> Array:
    """Flat gradient over the parameters of Σ upstream · output, with ``upstream`` (n, out)."""
    parts: list[Array] = []
    for layer in range(len(views) - 1, -1, -1):
        parts += [upstream.sum(axis=0), (values[layer].T @ upstream).ravel()]
        if layer:
            weights = views[layer][0]
            # A product with one inner index is an outer product, which is faster elementwise.
            upstream = upstream @ weights.T if upstream.shape[1] > 1 else upstream * weights.T
            upstream *= hidden_slopes[layer - 1]
    return np.concatenate(parts[::-1])


BLOCK = 8192
"""Rows of a large batch that go through the network together, so that their activations fit in the cache."""


@dataclass(frozen=True)
class Architecture:
    """The network of the mean."""

    sizes: Sizes  # from observation to action
    activation: str = "tanh"  # of the hidden layers, a key of ``ACTIVATIONS``
    tanh_mean: bool = False  # whether the mean is the tanh of the network's output, or the output


def passed(
    architecture: Architecture, theta: Array, observations: Array
) -> tuple[Layers, list[Array], list[Array]]:
    """The layers, their values at the observations (n, o), and the slopes of the hidden activations."""
    views, activation = layers(architecture.sizes, theta), ACTIVATIONS[architecture.activation]
    values = forward(views, observations, activation)
    return views, values, [activation.slope(hidden) for hidden in values[1:-1]]


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
    return mean + np.exp(log_sigma) * generator.standard_normal(mean.shape, np.float32)


def blocks(rows: int) -> list[slice]:
    """Slices of at most ``BLOCK`` rows."""
    return [slice(start, start + BLOCK) for start in range(0, rows, BLOCK)]


def log_density(mean: Array, log_sigma: Array, actions: Array) -> Array:
    """Log density of the actions (n,), without the constant −a/2 · log 2π."""
    scaled = (actions - mean) * np.exp(-log_sigma)
    return -0.5 * np.einsum("na,na->n", scaled, scaled) - log_sigma.sum()


def gain(mean: Array, log_sigma: Array, batch: Batch, old_log_density: Array) -> float:
    """The surrogate of a policy with the given means (n, a) and log σ (a,), which an update raises.

    It is the mean of new / old density × advantage (Schulman et al. 2015, eq. 14).
    """
    ratio = np.exp(log_density(mean, log_sigma, batch.actions) - old_log_density)
    return float(np.mean(ratio * batch.advantages, dtype=np.float64))


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
    views, values, hidden_slopes = passed(architecture, theta, batch.observations[rows])
    log_sigma = theta[-architecture.sizes[-1] :]
    mean = np.tanh(values[-1]) if architecture.tanh_mean else values[-1]
    scaled = (batch.actions[rows] - mean) * np.exp(-log_sigma)
    weighted = batch.advantages[rows, None] / len(batch.observations)
    upstream = weighted * scaled * np.exp(-log_sigma)
    if architecture.tanh_mean:
        upstream = upstream * (1 - mean * mean)
    sigma_part = np.sum(weighted * (scaled * scaled - 1), axis=0)
    return np.concatenate([gradient(views, values, hidden_slopes, upstream), sigma_part])


def fisher_product(
    architecture: Architecture, theta: Array, observations: Array, damping: float
) -> Callable[[Array], Array]:
    """The map v → (F + damping · I) v, with F the Fisher matrix of the policy over the states.

    It is exact. For a Gaussian, F = Jᵀ diag(1/σ²) J over the means, and 2 I over log σ.
    """
    sizes, outputs = architecture.sizes, architecture.sizes[-1]
    views, values, hidden_slopes = passed(architecture, theta, observations)
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


def exported(
    architecture: Architecture,
    theta: Array,
    moments: Moments,
    box: tuple[Array, Array],
    *,
    deterministic: bool,
) -> Policy:
    """The policy of the parameters; its actions equal the agent's bit for bit on batches of the same size.

    Args:
        architecture: the network of the mean.
        theta: the parameters, log σ last.
        moments: of the observations; those of no observations normalize nothing.
        box: middle and half width of the action space, (a,) each.
        deterministic: whether the action is the mean or a sample.
    """
    network, normalization = layers(architecture.sizes, theta), dict[str, Any]()
    if moments.count:
        normalization = {"observation_mean": moments.mean, "observation_scale": scale(moments)}
        normalization["observation_clip"] = CLIP
    return Policy(
        action_offset=box[0].ravel(),
        action_scale=box[1].ravel(),
        weights=tuple(weights for weights, _ in network),
        biases=tuple(bias for _, bias in network),
        activation=architecture.activation,
        output_activation="tanh" if architecture.tanh_mean else "linear",
        head="deterministic" if deterministic else "gaussian",
        log_sigma=theta[-architecture.sizes[-1] :],
        **normalization,
    )
