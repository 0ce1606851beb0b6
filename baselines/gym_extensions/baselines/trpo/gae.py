"""Generalised advantage estimation (Schulman et al. 2016) over lanes with autoreset."""

from __future__ import annotations

import numpy as np

from gym_extensions.baselines.agent import Array


def advantages(
    rewards: Array, values: Array, terminated: Array, truncated: Array, *, discount: float, trace_decay: float
) -> Array:
    """Advantages (T, lanes) for rewards (T, lanes) and values (T + 1, lanes), row t + 1 being after step t.

    A terminated step is worth nothing afterwards; a truncated one (time limit), like the last row, is worth
    the value of the state that it leads to. Rows of a reset (the step after an episode's end) come out
    meaningless and must be left out by the caller.
    """
    steps = len(rewards)
    found = np.empty(rewards.shape, np.float64)
    carried = np.zeros(rewards.shape[1])
    ended = terminated | truncated
    for t in range(steps - 1, -1, -1):
        surprise = rewards[t] + discount * values[t + 1] * ~terminated[t] - values[t]
        carried = surprise + discount * trace_decay * ~ended[t] * carried
        found[t] = carried
    return found
