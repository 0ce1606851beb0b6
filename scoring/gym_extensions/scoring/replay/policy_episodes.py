"""Episodes of a stored policy on given seeds. Loads a simulator."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from gym_extensions.catalog.bodies.success import IS_SUCCESS
from gym_extensions.catalog.task import Task
from gym_extensions.envs import make_vec
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.policies import Policy


class Outcome(NamedTuple):
    """The end of an episode, as a row of a log states it.

    ``return_`` is the sum of all rewards (``math.fsum``). ``success`` is None where the task defines none.
    """

    length: int
    return_: float
    terminated: bool
    success: bool | None


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

    def episodes(self, policy: Policy, rng: np.random.Generator | None = None) -> list[Outcome]:
        """The first episode of every environment.

        All environments are stepped until the last of these episodes ends, as in the evaluation that a log
        records. A deterministic policy then repeats the logged episodes bit for bit, if the versions and the
        BLAS kernels are those of the log.

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
        outcomes: dict[int, Outcome] = {}
        while len(outcomes) < len(rewards):
            running = [index not in outcomes for index in range(len(rewards))]
            with np.errstate(all="ignore"):
                actions = policy.act(observations, rng, self._index).reshape(len(rewards), *space.shape)
            if not np.isfinite(actions[running]).all():
                raise BenchError("bad-actions", "The policy gives an action that is not finite.")
            actions = np.clip(np.nan_to_num(actions), space.low, space.high).astype(space.dtype)
            observations, reward, terminated, truncated, infos = env.step(actions)
            for index in np.flatnonzero(running).tolist():
                rewards[index].append(float(reward[index]))
            for index in np.flatnonzero(running & (terminated | truncated)).tolist():
                return_ = math.fsum(rewards[index])
                success = _success(infos, index)
                outcomes[index] = Outcome(len(rewards[index]), return_, bool(terminated[index]), success)
        return [outcomes[index] for index in range(len(rewards))]

    def close(self) -> None:
        """Closes the environments."""
        self._env.close()


def _success(infos: dict[str, Any], index: int) -> bool | None:
    is_defined = IS_SUCCESS in infos and infos[f"_{IS_SUCCESS}"][index]
    return bool(infos[IS_SUCCESS][index]) if is_defined else None
