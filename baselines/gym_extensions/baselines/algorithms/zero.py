"""The zero action: one of the two agents that measure the floor. On many tasks it beats random actions."""

from __future__ import annotations

from pathlib import Path

import gymnasium as gym
import numpy as np

from gym_extensions.baselines.agent import Array, Card, VectorEnv
from gym_extensions.baselines.checkpoint import save_arrays
from gym_extensions.rollouts.policies import Policy


class Zero:
    """Returns the zero action for every observation."""

    def __init__(self, observation_space: gym.spaces.Box, action_space: gym.spaces.Box, seed: int) -> None:
        self._shape = action_space.shape

    def act(self, observations: Array) -> Array:
        """Zeros (num_envs, …)."""
        return np.zeros((len(observations), *self._shape), np.float32)

    def learn(self, env: VectorEnv, steps: int) -> None:
        """Does nothing and takes no steps."""

    def policy(self) -> Policy:
        """A constant policy without a network."""
        size = int(np.prod(self._shape))
        return Policy(np.zeros(size, np.float32), np.ones(size, np.float32))

    def card(self) -> Card:
        """The agent's description in the manifest."""
        text = "The zero action in every step; learns nothing."
        return Card("zero", title="Zero action", description=text, evaluation="deterministic")

    def save(self, path: Path) -> None:
        """Writes an empty archive: the agent has no state."""
        save_arrays(path)

    def load(self, path: Path) -> None:
        """Does nothing: the agent has no state."""


make = Zero
