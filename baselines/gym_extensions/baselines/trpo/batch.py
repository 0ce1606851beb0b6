"""Collects one batch of transitions from a vector environment."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from gym_extensions.baselines.agent import Array, VectorEnv


@dataclass(frozen=True)
class Transitions:
    """T vector steps: observations (T + 1, num_envs, o); the rest (T, num_envs, …).

    ``valid`` is False in the rows in which an environment was being reset.
    """

    observations: Array
    actions: Array
    rewards: Array
    terminated: Array
    truncated: Array
    valid: Array


class Collector:
    """A vector environment between two batches: episodes continue across batches."""

    def __init__(self, env: VectorEnv) -> None:
        observations, _ = env.reset()
        self._env = env
        self._observations: Array = np.array(observations, np.float32)
        self._resetting = np.zeros(env.num_envs, bool)

    def collect(
        self, sample: Callable[[Array], Array], to_env: Callable[[Array], Array], transitions: int
    ) -> Transitions:
        """Steps until at least ``transitions`` are taken; fewer than ``num_envs`` are taken beyond that.

        Args:
            sample: the policy's actions (num_envs, a) for observations (num_envs, o).
            to_env: maps these actions to the environment's action box.
            transitions: transitions to take; the steps that reset an environment do not count.
        """
        observations, actions, rewards = [self._observations], [], []
        terminated, truncated, valid = [], [], []
        count = 0
        while count < transitions:
            action = sample(observations[-1])
            next_observations, reward, ends, cuts, _ = self._env.step(to_env(action))
            stepped = ~self._resetting
            self._resetting = (ends | cuts) & stepped
            count += int(stepped.sum())
            observations.append(np.array(next_observations, np.float32))
            actions.append(action)
            rewards.append(np.array(reward, np.float64))
            terminated.append(np.array(ends))
            truncated.append(np.array(cuts))
            valid.append(stepped)
        self._observations = observations[-1]
        columns = (observations, actions, rewards, terminated, truncated, valid)
        return Transitions(*map(np.stack, columns))
