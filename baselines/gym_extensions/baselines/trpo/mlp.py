"""A multilayer perceptron as pure functions of one flat parameter vector: value and derivatives.

Written out instead of left to automatic differentiation: the Fisher product of a conjugate-gradient step is
then one forward derivative and one backward pass over activations that are computed once a batch.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from gym_extensions.baselines.agent import Array

Sizes = tuple[int, ...]
"""Width of every layer, input and output included; ReLU between, nothing after the last."""


def parameter_count(sizes: Sizes) -> int:
    """Number of weights and biases."""
    return sum((fan_in + 1) * fan_out for fan_in, fan_out in pairwise(sizes))


def initial(sizes: Sizes, rng: np.random.Generator, last_scale: float = 1.0) -> Array:
    """He-uniform hidden weights, Glorot-uniform output × ``last_scale``, zero biases; flat float32."""
    parts = []
    for layer, (fan_in, fan_out) in enumerate(pairwise(sizes)):
        last = layer == len(sizes) - 2
        bound = last_scale * np.sqrt(6.0 / (fan_in + fan_out)) if last else np.sqrt(6.0 / fan_in)
        parts += [rng.uniform(-bound, bound, fan_in * fan_out), np.zeros(fan_out)]
    return np.concatenate(parts).astype(np.float32)


def layers(sizes: Sizes, theta: Array) -> list[tuple[Array, Array]]:
    """Views of the flat vector: (weights (in, out), bias (out,)) of every layer."""
    views, at = [], 0
    for fan_in, fan_out in pairwise(sizes):
        end = at + fan_in * fan_out
        views.append((theta[at:end].reshape(fan_in, fan_out), theta[end : end + fan_out]))
        at = end + fan_out
    return views


def forward(views: list[tuple[Array, Array]], inputs: Array) -> list[Array]:
    """The input, every hidden activation and the output, each (n, width)."""
    values = [inputs]
    for weights, bias in views[:-1]:
        hidden = values[-1] @ weights
        hidden += bias
        values.append(np.maximum(hidden, 0, out=hidden))
    weights, bias = views[-1]
    values.append(values[-1] @ weights + bias)
    return values


def slopes(values: list[Array]) -> list[Array]:
    """Derivative of every hidden activation, 1 or 0, in the activations' own type."""
    return [np.sign(hidden) for hidden in values[1:-1]]


def tangent(
    views: list[tuple[Array, Array]],
    values: list[Array],
    gates: list[Array],
    direction: list[tuple[Array, Array]],
) -> Array:
    """Derivative of the output (n, out) along a direction of the parameters."""
    moved: Array | None = None
    for layer, ((weights, _), (d_weights, d_bias)) in enumerate(zip(views, direction, strict=True)):
        step = values[layer] @ d_weights
        step += d_bias
        if moved is not None:
            step += moved @ weights
        if layer < len(gates):
            step *= gates[layer]
        moved = step
    if moved is None:
        raise ValueError("a network needs a layer")
    return moved


def gradient(
    views: list[tuple[Array, Array]], values: list[Array], gates: list[Array], upstream: Array
) -> Array:
    """Flat gradient over the parameters of Σ upstream · output, upstream being (n, out)."""
    parts: list[Array] = []
    for layer in range(len(views) - 1, -1, -1):
        parts += [upstream.sum(axis=0), (values[layer].T @ upstream).ravel()]
        if layer:
            upstream = upstream @ views[layer][0].T
            upstream *= gates[layer - 1]
    return np.concatenate(parts[::-1])
