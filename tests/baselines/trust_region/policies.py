"""Small policies and batches for the tests of this folder."""

from collections.abc import Callable

import numpy as np
import pytest

from gym_extensions.baselines.agent import Array
from gym_extensions.baselines.trust_region import policy
from gym_extensions.baselines.trust_region.policy import Architecture, Batch

SIZES = (3, 6, 5, 2)
ARCHITECTURES = (Architecture(SIZES, "tanh", tanh_mean=False), Architecture(SIZES, "relu", tanh_mean=True))
"""The architectures of ``trpo`` and ``trpo-2017``, with small layers."""
each_architecture = pytest.mark.parametrize("architecture", ARCHITECTURES, ids=["linear", "tanh"])


def random_policy(architecture: Architecture, seed: int = 0) -> Array:
    """Nonzero parameters in float64."""
    rng = np.random.default_rng(seed)
    network = policy.initial(architecture.sizes, rng).astype(np.float64)
    theta = np.concatenate([network, np.zeros(architecture.sizes[-1])])
    return theta + 0.1 * rng.standard_normal(theta.shape)


def random_batch(n: int = 40, seed: int = 1) -> Batch:
    """Standard normal observations (n, 3), actions (n, 2) and advantages (n,)."""
    rng = np.random.default_rng(seed)
    return Batch(rng.standard_normal((n, 3)), rng.standard_normal((n, 2)), rng.standard_normal(n))


def surrogate(architecture: Architecture, old: Array, new: Array, batch: Batch) -> float:
    """The mean of probability ratio times advantage, minus its value at the old parameters."""
    before, after = (
        policy.log_density(*policy.mean_and_log_sigma(architecture, theta, batch.observations), batch.actions)
        for theta in (old, new)
    )
    return float(np.mean((np.exp(after - before) - 1) * batch.advantages))


def numeric_gradient(function: Callable[[Array], float], at: Array, width: float = 1e-6) -> Array:
    """Central differences."""
    slope = np.empty_like(at)
    for index in range(len(at)):
        step = np.zeros_like(at)
        step[index] = width
        slope[index] = (function(at + step) - function(at - step)) / (2 * width)
    return slope
