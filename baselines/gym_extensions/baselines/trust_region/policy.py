"""The policy of TRPO: a Gaussian whose mean is a multilayer perceptron, with its derivatives."""

import functools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from gym_extensions.baselines.agent import Array
from gym_extensions.files import compiled

CLIP = 10.0
"""Standardized observations are clipped to ±10 standard deviations, as by SB3's ``VecNormalize``."""
LEAST_DEVIATION = 1e-3
"""Smallest deviation of a policy's observations, so that rounding errors of constant ones stay small."""
EPSILON = 1e-8
"""Added to the standard deviation."""


@dataclass(frozen=True, eq=False)
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


@functools.lru_cache(maxsize=4)
def scale(moments: Moments, least: float = LEAST_DEVIATION) -> Array:
    """What observations are divided by (o,): the standard deviation, at least ``least``."""
    deviation = np.sqrt(moments.squares / max(moments.count, 1.0))
    return np.maximum(deviation, least) + EPSILON


def standardize(moments: Moments, observations: Array, least: float = LEAST_DEVIATION) -> Array:
    """Observations (n, o) minus the mean, over the standard deviation, clipped; float32."""
    scaled = (observations - moments.mean) / scale(moments, least)
    # np.clip takes three times as long for the few rows of a step.
    return np.minimum(np.maximum(scaled, -CLIP), CLIP).astype(np.float32)


def network_inputs(moments: Moments, observations: Array) -> Array:
    """Standardized observations (n, o); raw ones while the moments are those of no observations."""
    return standardize(moments, observations) if moments.count else observations


Sizes = tuple[int, ...]
"""Width of every layer, input and output included."""


TANH, RELU = range(2)
ACTIVATIONS = {"relu": RELU, "tanh": TANH}
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


def layers(sizes: Sizes, theta: Array) -> list[tuple[Array, Array]]:
    """The weights (in, out) and the bias (out,) of every layer, as views of the flat vector."""
    views, start = [], 0
    for fan_in, fan_out in pairwise(sizes):
        end = start + fan_in * fan_out
        views.append((theta[start:end].reshape(fan_in, fan_out), theta[end : end + fan_out]))
        start = end + fan_out
    return views


BLOCK = 200
"""Rows of a batch that go through the network together, so that their values stay in the cache."""


@dataclass(frozen=True)
class Architecture:
    """The network of the mean."""

    sizes: Sizes  # from observation to action
    activation: str = "tanh"  # of the hidden layers, a key of ``ACTIVATIONS``
    tanh_mean: bool = False  # whether the mean is the tanh of the network's output, or the output

    @property
    def log_sigmas(self) -> slice:
        """Where log σ is in the flat vector of a policy: at its end."""
        return slice(-self.sizes[-1], None)


Values = tuple[Array, ...]
"""The inputs of a network, the values of every hidden layer and the outputs, (n, width) each."""


def forward(architecture: Architecture, theta: Array, inputs: Array) -> Values:
    """The values of all layers for inputs (n, o)."""
    values, is_tanh = [np.ascontiguousarray(inputs, theta.dtype)], architecture.activation == "tanh"
    *hidden_layers, (weights, bias) = layers(architecture.sizes, theta)
    for hidden_weights, hidden_bias in hidden_layers:
        hidden = values[-1] @ hidden_weights
        hidden += hidden_bias
        values.append(np.tanh(hidden, out=hidden) if is_tanh else np.maximum(hidden, 0, out=hidden))
    return (*values, values[-1] @ weights + bias)


def outputs(architecture: Architecture, theta: Array, inputs: Array) -> Array:
    """The outputs (n, out) of the network for inputs (n, o), of which no other values are needed."""
    starts = range(0, len(inputs), BLOCK)
    parts = [forward(architecture, theta, inputs[start : start + BLOCK])[-1] for start in starts]
    return parts[0] if len(parts) == 1 else np.concatenate(parts)


@compiled
def layer(sizes: Sizes, theta: Array, number: int) -> tuple[Array, Array]:
    """The pair of :func:`layers` with the given number."""
    start = 0
    for before in range(number):
        start += (sizes[before] + 1) * sizes[before + 1]
    end = start + sizes[number] * sizes[number + 1]
    return theta[start:end].reshape((sizes[number], sizes[number + 1])), theta[end : end + sizes[number + 1]]


@compiled
def times_slope(change: Array, values: Array, activation: int) -> None:
    """Multiplies ``change`` (n, w) by the slope of the activation, which is known from its values."""
    zero = change.dtype.type(0)
    for row in range(len(change)):
        changes, at = change[row], values[row]
        for unit in range(changes.size):
            if activation == TANH:
                changes[unit] -= changes[unit] * at[unit] * at[unit]
            elif not at[unit] > 0:
                changes[unit] = zero


@compiled
def jvp(sizes: Sizes, theta: Array, activation: int, values: Sequence[Array], direction: Array) -> Array:
    """Derivative of the output (n, out) along a direction of the parameters (p,)."""
    change, last = values[0], len(sizes) - 2
    for number in range(last + 1):
        weights, (d_weights, d_bias) = layer(sizes, theta, number)[0], layer(sizes, direction, number)
        step = np.dot(values[number], d_weights)
        through = np.dot(change, weights) if number else np.zeros_like(step)
        for row in range(len(step)):
            for unit in range(d_bias.size):
                step[row, unit] += through[row, unit] + d_bias[unit]
        if number < last:
            times_slope(step, values[number + 1], activation)
        change = step
    return change


@compiled
def add_gradient(  # noqa: PLR0917
    sizes: Sizes, theta: Array, activation: int, values: Sequence[Array], upstream: Array, total: Array
) -> None:
    """Adds to ``total`` (p,) the gradient over the parameters of Σ upstream · output."""
    for number in range(len(sizes) - 2, -1, -1):
        weights, (d_weights, d_bias) = layer(sizes, theta, number)[0], layer(sizes, total, number)
        d_weights += np.dot(values[number].T, upstream)
        for row in range(len(upstream)):
            for unit in range(d_bias.size):
                d_bias[unit] += upstream[row, unit]
        if number:
            upstream = np.dot(upstream, weights.T)
            times_slope(upstream, values[number], activation)


@compiled
def backward(sizes: Sizes, theta: Array, activation: int, values: Values, upstream: Array) -> Array:
    """The gradient over the parameters (p,) of Σ upstream · output, with ``upstream`` (n, out)."""
    total = np.zeros_like(theta)
    for start in range(0, len(upstream), BLOCK):
        part = [each[start : start + BLOCK] for each in values]
        add_gradient(sizes, theta, activation, part, upstream[start : start + BLOCK], total)
    return total


@compiled
def gauss_newton_product(  # noqa: PLR0917
    sizes: Sizes, theta: Array, activation: int, values: Values, metric: Array, direction: Array
) -> Array:
    """Jᵀ diag(metric) J · direction (p,), with J the derivative of all outputs and ``metric`` (n, out)."""
    total = np.zeros_like(theta)
    for start in range(0, len(metric), BLOCK):
        part = [each[start : start + BLOCK] for each in values]
        upstream = jvp(sizes, theta, activation, part, direction) * metric[start : start + BLOCK]
        add_gradient(sizes, theta, activation, part, upstream, total)
    return total


@dataclass(frozen=True)
class Batch:
    """The input of an update: observations (n, o), actions before clipping (n, a) and advantages (n,)."""

    observations: Array
    actions: Array
    advantages: Array


def means(architecture: Architecture, output: Array) -> Array:
    """The means (n, a) of the policy for outputs (n, a) of the network."""
    return np.tanh(output) if architecture.tanh_mean else output


def mean_and_log_sigma(architecture: Architecture, theta: Array, observations: Array) -> tuple[Array, Array]:
    """Means (n, a) and log σ (a,)."""
    mean = means(architecture, outputs(architecture, theta, observations))
    return mean, theta[architecture.log_sigmas]


def sampled(mean: Array, log_sigma: Array, generator: np.random.Generator) -> Array:
    """Actions (n, a) of a Gaussian with means (n, a) and log σ (a,)."""
    return mean + np.exp(log_sigma) * generator.standard_normal(mean.shape, np.float32)


def log_density(mean: Array, log_sigma: Array, actions: Array) -> Array:
    """Log density of the actions (n,), without the constant −a/2 · log 2π."""
    scaled = (actions - mean) * np.exp(-log_sigma)
    return -0.5 * np.einsum("na,na->n", scaled, scaled) - log_sigma.sum()


def surrogate(mean: Array, log_sigma: Array, batch: Batch, old_log_density: Array) -> float:
    """The surrogate of a policy with the given means (n, a) and log σ (a,), which an update raises.

    It is the mean of new / old density × advantage (Schulman et al. 2015, eq. 14).
    """
    ratio = np.exp(log_density(mean, log_sigma, batch.actions) - old_log_density)
    return float(np.mean(ratio * batch.advantages, dtype=np.float64))


def mean_kl(old_mean: Array, old_log_sigma: Array, mean: Array, log_sigma: Array) -> float:
    """Mean KL(old ‖ new) over the states."""
    inverse = np.exp(-2 * log_sigma)
    gap = np.mean((mean - old_mean) ** 2, axis=0, dtype=np.float64)
    terms = log_sigma - old_log_sigma + 0.5 * (np.exp(2 * old_log_sigma) + gap) * inverse - 0.5
    return float(np.sum(terms, dtype=np.float64))


def gradient(architecture: Architecture, theta: Array, values: Values, upstream: Array) -> Array:
    """The gradient over the parameters (p,) of Σ upstream · mean, with ``upstream`` (n, a)."""
    if architecture.tanh_mean:
        upstream = upstream * (1 - np.tanh(values[-1]) ** 2)
    network = architecture.sizes, theta, ACTIVATIONS[architecture.activation]
    return backward(*network, values, np.ascontiguousarray(upstream, theta.dtype))


def surrogate_gradient(architecture: Architecture, theta: Array, batch: Batch, values: Values) -> Array:
    """Gradient (p,) of the surrogate at new = old, where the layers have the values."""
    deviations = np.exp(theta[architecture.log_sigmas])
    weighted = batch.advantages[:, None] / len(batch.advantages)
    scaled = (batch.actions - means(architecture, values[-1])) / deviations
    slope = gradient(architecture, theta, values, weighted * scaled / deviations)
    slope[architecture.log_sigmas] = np.sum(weighted * (scaled * scaled - 1), axis=0)
    return slope


def fisher_product(
    architecture: Architecture, theta: Array, values: Values, damping: float
) -> Callable[[Array], Array]:
    """The map v → (F + damping · I) v, with F the Fisher matrix over states at which the layers have values.

    It is exact. For a Gaussian, F = Jᵀ diag(1/σ²) J over the means, and 2 I over log σ.
    """
    network = architecture.sizes, theta, ACTIVATIONS[architecture.activation]
    log_sigmas = architecture.log_sigmas
    metric = np.full_like(values[-1], np.exp(-2 * theta[log_sigmas]) / len(values[-1]))
    if architecture.tanh_mean:
        metric *= (1 - np.tanh(values[-1]) ** 2) ** 2

    def product(vector: Array) -> Array:
        image = gauss_newton_product(*network, values, metric, vector) + damping * vector
        image[log_sigmas] += 2 * vector[log_sigmas]
        return image

    return product
