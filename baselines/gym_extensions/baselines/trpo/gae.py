"""Generalized advantage estimation (Schulman et al. 2016) over vector environments with autoreset."""

from __future__ import annotations

import numpy as np

from gym_extensions.baselines.agent import Array


def advantages(
    rewards: Array, values: Array, terminated: Array, truncated: Array, *, discount: float, gae_lambda: float
) -> Array:
    """Advantages (T, num_envs) for rewards (T, num_envs) and values (T + 1, num_envs).

    Row t + 1 of ``values`` belongs to the state after step t. A terminated step has no value after it. A
    truncated step (time limit) is bootstrapped with the value of the state it leads to, as is the last row.
    The rows of a reset, which follow an episode's end, are meaningless; the caller drops them.
    """
    estimates = np.empty(rewards.shape, np.float64)
    running = np.zeros(rewards.shape[1])
    ended = terminated | truncated
    for t in range(len(rewards) - 1, -1, -1):
        residual = rewards[t] + discount * values[t + 1] * ~terminated[t] - values[t]
        running = residual + discount * gae_lambda * ~ended[t] * running
        estimates[t] = running
    return estimates
