"""A multilayer perceptron as pure functions of one flat parameter vector: values and derivatives.

The derivatives are written out instead of left to automatic differentiation. The Fisher product of a
conjugate-gradient step is then one forward derivative and one backward pass over activations that are
computed once per batch.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from gym_extensions.baselines.agent import Array

Sizes = tuple[int, ...]
"""Width of every layer, input and output included."""
Layers = list[tuple[Array, Array]]
"""Weights (in, out) and bias (out,) of every layer."""


@dataclass(frozen=True)
class Activation:
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


def slopes(values: list[Array], activation: Activation) -> list[Array]:
    """Derivative of every hidden activation at the values that ``forward`` returned."""
    return [activation.slope(hidden) for hidden in values[1:-1]]


def tangent(views: Layers, values: list[Array], hidden_slopes: list[Array], direction: Layers) -> Array:
    """Derivative of the output (n, out) along a direction of the parameters."""
    change: Array | None = None
    for layer, ((weights, _), (d_weights, d_bias)) in enumerate(zip(views, direction, strict=True)):
        step = values[layer] @ d_weights
        step += d_bias
        if change is not None:
            step += change @ weights
        if layer < len(hidden_slopes):
            step *= hidden_slopes[layer]
        change = step
    if change is None:
        raise ValueError("a network needs at least one layer")
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
