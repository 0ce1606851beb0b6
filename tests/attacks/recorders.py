"""The honest submissions that attacks start from: short tasks and cheap agents."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np

from gym_extensions.baselines import train
from gym_extensions.baselines.agent import Array, Card, VectorEnv
from gym_extensions.rollouts.policies import Policy

from .workshop import Recorder

HOPPER = "hopper-motor-noise"
"""Two tasks, whose episodes are short."""
RUNS = range(5)


class Linear:
    """A linear policy of random weights; after each stage others, of twice the size.

    Args:
        observation_space: the observations.
        action_space: the actions.
        seed: draws the weights.
        sigma: standard deviation of the actions in half widths of the action space; 0 is deterministic.
    """

    SIGMA = 0.0

    def __init__(self, observation_space: gym.spaces.Box, action_space: gym.spaces.Box, seed: int) -> None:
        self._rng = np.random.default_rng(seed)
        self._acting = np.random.default_rng(seed + 1)
        self._inputs = int(np.prod(observation_space.shape))
        self._middle = np.asarray((action_space.high + action_space.low) / 2, np.float64).ravel()
        self._half = np.asarray((action_space.high - action_space.low) / 2, np.float64).ravel()
        self._scale = 0.05
        self._draw()

    def _draw(self) -> None:
        weights = self._rng.normal(0.0, self._scale, (self._inputs, len(self._half)))
        noise: dict[str, Any] = {}
        if self.SIGMA:
            noise = {"head": "gaussian", "log_sigma": np.full(len(self._half), np.log(self.SIGMA))}
        self._policy = Policy(
            self._middle, self._half, (weights,), (np.zeros(len(self._half)),), squash="tanh", **noise
        )

    def act(self, observations: Array) -> Array:
        """The policy's actions."""
        return self._policy.act(observations, self._acting)

    def learn(self, env: VectorEnv, steps: int) -> None:
        """Draws other weights."""
        self._scale *= 2.0
        self._draw()

    def policy(self) -> Policy:
        """The policy."""
        return self._policy

    def card(self) -> Card:
        """The description in the manifest."""
        evaluation = "sampled" if self.SIGMA else "deterministic"
        return Card(
            "linear", title="Linear", evaluation=evaluation, parameters=self._inputs * len(self._half)
        )


class Gaussian(Linear):
    """The same with noise."""

    SIGMA = 0.3


def recorder(agent: Any, group: str, *protocols: str, budget: str = "100k", runs: Any = RUNS) -> Recorder:
    """Records an agent."""

    def record(folder: Path) -> None:
        train(agent, group, protocols, budget, runs, out=folder, progress=False)

    return record


RECORDERS = {
    "random": recorder("random", HOPPER, "single"),
    "linear": recorder(Linear, HOPPER, "sequential", "single"),
    "gaussian": recorder(Gaussian, HOPPER, "single"),
    "trpo": recorder("trpo", HOPPER, "single", budget="smoke", runs=range(8)),
    "striker": recorder("random", "striker", "single", budget="smoke", runs=0),
    "navigation": recorder("random", "nav-state", "single", budget="smoke", runs=0),
}
"""By name."""
