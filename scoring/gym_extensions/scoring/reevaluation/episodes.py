"""Returns of a policy on given seeds. Loads a simulator."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from gym_extensions.catalog.task import Task
from gym_extensions.envs import make_vec
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.policies import Policy


class Environments:
    """One environment of a task per seed, used for many policies.

    Args:
        task: the task.
        index: its index in the group's training order.
        seeds: the reset seeds.
    """

    def __init__(self, task: Task, index: int, seeds: Sequence[int]) -> None:
        self._index, self._seeds = index, list(seeds)
        self._env: Any = make_vec(task, len(seeds))

    def returns(self, policy: Policy, rng: np.random.Generator) -> list[float]:
        """The return of the first episode of every environment.

        Args:
            policy: the policy.
            rng: draws the actions of a policy that samples them.

        Raises:
            BenchError: the policy has another number of observations or actions than the task, or gives
                actions that are not finite.
        """
        env, space = self._env, self._env.single_action_space
        if len(policy.action_offset) != math.prod(space.shape):
            message = f"The policy has {len(policy.action_offset)} actions; the task has {space.shape[0]}."
            raise BenchError("bad-actions", message)
        observations, _ = env.reset(seed=self._seeds)
        rewards: list[list[float]] = [[] for _ in self._seeds]
        running = np.ones(len(self._seeds), np.bool_)
        while running.any():
            with np.errstate(all="ignore"):
                actions = policy.act(observations, rng, self._index).reshape(len(running), *space.shape)
            if not np.isfinite(actions[running]).all():
                raise BenchError("bad-actions", "The policy gives an action that is not finite.")
            actions = np.clip(np.nan_to_num(actions), space.low, space.high).astype(space.dtype)
            observations, reward, terminated, truncated, _ = env.step(actions)
            for index in np.flatnonzero(running).tolist():
                rewards[index].append(float(reward[index]))
            running &= ~(terminated | truncated)
        return [math.fsum(values) for values in rewards]

    def close(self) -> None:
        """Closes the environments."""
        self._env.close()
