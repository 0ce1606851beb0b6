"""The zero action: the other half of the floor; standing still is better than flailing on many tasks."""

from __future__ import annotations

from pathlib import Path

import gymnasium as gym
import numpy as np

from gym_extensions.baselines.agent import Array, Card, VectorEnv
from gym_extensions.baselines.checkpoint import save_arrays


class Still:
    """The zero action, whatever is seen."""

    def __init__(self, observation_space: gym.spaces.Box, action_space: gym.spaces.Box, seed: int) -> None:
        self._shape = action_space.shape

    def act(self, observations: Array) -> Array:
        """Zeros."""
        return np.zeros((len(observations), *self._shape), np.float32)

    def learn(self, env: VectorEnv, steps: int) -> None:
        """Nothing: no step is taken."""

    def card(self) -> Card:
        """The manifest's words."""
        text = "The zero action in every step; learns nothing."
        return Card("still", title="Still", description=text, evaluation="deterministic")

    def save(self, path: Path) -> None:
        """Writes an empty archive: there is nothing to keep."""
        save_arrays(path)

    def load(self, path: Path) -> None:
        """Nothing to restore."""


make = Still
