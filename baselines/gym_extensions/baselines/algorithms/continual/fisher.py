"""The diagonal of the Fisher matrix of a Gaussian policy, exact over the sampled states."""

from __future__ import annotations

import numpy as np

from gym_extensions.baselines.agent import Array
from gym_extensions.baselines.trpo.gaussian_policy import Architecture
from gym_extensions.baselines.trpo.mlp import ACTIVATIONS, forward, layers, slopes


def diagonal_fisher(architecture: Architecture, theta: Array, inputs: Array) -> Array:
    """Mean over the states of Σₐ (∂μₐ/∂θᵢ)² / σₐ², and 2 for log σ; float64 (p,).

    The expectation over actions is exact, as in Wolczyk et al. 2021, appendix.

    Args:
        architecture: the policy's network.
        theta: the parameters (p,).
        inputs: of the network (n, o), n > 0.
    """
    outputs = architecture.sizes[-1]
    views, activation = layers(architecture.sizes, theta), ACTIVATIONS[architecture.activation]
    values = forward(views, inputs, activation)
    hidden_slopes = slopes(values, activation)
    total = np.zeros(len(theta))
    for output in range(outputs):
        upstream = np.zeros_like(values[-1])
        upstream[:, output] = np.exp(-theta[len(theta) - outputs + output])
        if architecture.tanh_mean:
            upstream[:, output] *= 1 - np.tanh(values[-1][:, output]) ** 2
        parts: list[Array] = [np.zeros(outputs)]
        for layer in range(len(views) - 1, -1, -1):
            squares = upstream.astype(np.float64) ** 2
            parts += [squares.sum(axis=0), (np.square(values[layer], dtype=np.float64).T @ squares).ravel()]
            if layer:
                upstream = (upstream @ views[layer][0].T) * hidden_slopes[layer - 1]
        total += np.concatenate(parts[::-1])
    total /= len(inputs)
    total[-outputs:] = 2.0
    return total
