"""Random actions and the zero action, the agents that measure the floor."""

from pathlib import Path

import gymnasium as gym
import numpy as np

from gym_extensions.baselines.agent import Array, Card, VectorEnv
from gym_extensions.baselines.generators import acting_and_learning, restore_generator, saved_generator
from gym_extensions.submissions.policies.mlp import Policy

FLOORS = ("random", "zero")


class Random:
    """Draws actions uniformly from the action space and ignores observations."""

    def __init__(self, observation_space: gym.spaces.Box, action_space: gym.spaces.Box, seed: int) -> None:
        self._low, self._high = action_space.low, action_space.high
        self._acting, _ = acting_and_learning(seed)

    def act(self, observations: Array) -> Array:
        shape = (len(observations), *self._low.shape)
        return self._acting.uniform(self._low, self._high, shape).astype(np.float32)

    def learn(self, env: VectorEnv, steps: int) -> None:
        """Does nothing and takes no steps."""

    def policy(self) -> Policy:
        middle, half = (self._high + self._low) / 2, (self._high - self._low) / 2
        return Policy(middle.ravel(), half.ravel(), head="uniform")

    def card(self) -> Card:
        return Card("random", title="Random actions", description="Uniformly random actions; learns nothing.")

    def save(self, path: Path) -> None:
        path.write_text(saved_generator(self._acting))

    def load(self, path: Path) -> None:
        restore_generator(self._acting, path.read_text())


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
        size = int(np.prod(self._shape))
        return Policy(np.zeros(size, np.float32), np.ones(size, np.float32))

    def card(self) -> Card:
        text = "The zero action in every step; learns nothing."
        return Card("zero", title="Zero action", description=text, evaluation="deterministic")

    def save(self, path: Path) -> None:
        path.touch()

    def load(self, path: Path) -> None:
        """Does nothing: the agent has no state."""
