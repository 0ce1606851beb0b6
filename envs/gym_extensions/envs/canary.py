"""Records rewards and observations of seeded episodes, as a short description of a task's behavior."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.task import Task
from gym_extensions.envs.make import build

SEEDS = (0, 1)
STEPS = 8
DIGITS = 12
"""Significant digits that are written: three more than the tolerance needs."""
TOLERANCE = 1e-9
"""Largest accepted difference, absolute below 1, relative above; differences between CPUs are smaller."""

GOLDEN = 0.6180339887498949


def actions(space: gym.spaces.Box) -> Iterator[NDArray[np.float32]]:
    """Yields actions spread evenly over the space by multiples of the golden ratio.

    Uses no generator and no libm.
    """
    low, high = space.low.astype(np.float64), space.high.astype(np.float64)
    size = low.size
    for step in range(STEPS):
        spread = np.modf((step * size + np.arange(size) + 1) * GOLDEN)[0]
        yield (low + (high - low) * spread.reshape(low.shape)).astype(np.float32)


def record(task: Task) -> list[dict[str, Any]]:
    """Returns seed, rewards, last observation and termination of one episode per seed."""
    env = build(task)
    try:
        return [_episode(env, seed) for seed in SEEDS]
    finally:
        env.close()


def _episode(env: gym.Env[Any, Any], seed: int) -> dict[str, Any]:
    assert isinstance(env.action_space, gym.spaces.Box)
    observation, _ = env.reset(seed=seed)
    rewards, terminated = [], False
    for action in actions(env.action_space):
        observation, reward, terminated, _, _ = env.step(action)
        rewards.append(_rounded(float(reward)))
        if terminated:
            break
    return {"seed": seed, "rewards": rewards, "observation": _summary(observation), "terminated": terminated}


def _rounded(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")


def _summary(observation: NDArray[Any]) -> Any:
    """The numbers of an observation, or the digest of a picture, whose integers are exact."""
    if observation.dtype.kind in "iu":
        return {"sha256": hashlib.sha256(observation.tobytes()).hexdigest(), "shape": list(observation.shape)}
    return [_rounded(float(value)) for value in observation]
