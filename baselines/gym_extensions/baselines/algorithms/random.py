"""Uniformly random actions: one of the two agents that measure the floor."""

from __future__ import annotations

from pathlib import Path

import gymnasium as gym
import numpy as np

from gym_extensions.baselines.agent import Array, Card, VectorEnv, acting_and_learning
from gym_extensions.baselines.checkpoint import load_arrays, restore_generator, save_arrays, saved_generator
from gym_extensions.rollouts.policies import Policy


class Random:
    """Draws actions uniformly from the action space and ignores observations."""

    def __init__(self, observation_space: gym.spaces.Box, action_space: gym.spaces.Box, seed: int) -> None:
        self._low, self._high = action_space.low, action_space.high
        self._acting, _ = acting_and_learning(seed)

    def act(self, observations: Array) -> Array:
        """One random action per environment."""
        shape = (len(observations), *self._low.shape)
        return self._acting.uniform(self._low, self._high, shape).astype(np.float32)

    def learn(self, env: VectorEnv, steps: int) -> None:
        """Does nothing and takes no steps."""

    def policy(self) -> Policy:
        """A uniform policy without a network."""
        middle, half = (self._high + self._low) / 2, (self._high - self._low) / 2
        return Policy(middle.ravel(), half.ravel(), head="uniform")

    def card(self) -> Card:
        """The agent's description in the manifest."""
        return Card("random", title="Random actions", description="Uniformly random actions; learns nothing.")

    def save(self, path: Path) -> None:
        """Writes the state of the random generator."""
        save_arrays(path, acting=saved_generator(self._acting))

    def load(self, path: Path) -> None:
        """Restores the state of the random generator."""
        restore_generator(self._acting, load_arrays(path)["acting"])


make = Random
