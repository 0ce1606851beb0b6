"""An oracle that knows the map and follows the shortest plan to the goal."""

from __future__ import annotations

import functools
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.task import Task
from gym_extensions.envs.navigation.env import course
from gym_extensions.envs.navigation.grid import Arena
from gym_extensions.envs.navigation.grid import arena as published_arena
from gym_extensions.envs.navigation.planner import NEVER, choose, look, steps_to_go
from gym_extensions.envs.navigation.vector_env import NavigationVectorEnv


class Oracle:
    """The plan for one arena. It acts on the agent's position.

    From every free point it reaches the goal without a collision in at most ``steps_from(point)`` steps. It
    plans over points half a unit apart, so a path that rounds corners more tightly may be a step shorter.
    """

    def __init__(self, arena: Arena) -> None:
        self.arena = arena
        self._goal = np.array(arena.goal)
        self.steps: NDArray[np.int16] = steps_to_go(arena.grid.solid, arena.goal[0], arena.goal[1])

    @classmethod
    @functools.cache
    def of(cls, task: Task) -> Oracle:
        """Returns the oracle of a navigation task. All families of one map and goal share it."""
        row = course(task)
        return cls.at(row.map, row.goal)

    @classmethod
    @functools.cache
    def at(cls, map_number: int, goal_number: int) -> Oracle:
        """Returns the oracle of a published map and goal, planned once per process."""
        return cls(published_arena(map_number, goal_number))

    def act(self, position: NDArray[np.float64]) -> NDArray[np.float32]:
        """Returns the displacement from a free position (2,), in units."""
        action = np.zeros(2, dtype=np.float32)
        choose(self.arena.grid.solid, self.steps, self._goal, position, action)
        return action

    def steps_from(self, position: NDArray[np.float64]) -> int:
        """Returns the number of steps within which the oracle reaches the goal from a free position (2,)."""
        return int(look(self.arena.grid.solid, self.steps, self._goal, position[0], position[1], NEVER)[0])


def oracle_returns(task: Task, seeds: Sequence[int]) -> NDArray[np.float64]:
    """Returns the oracle's return in one episode per reset seed, (seeds,).

    Tasks that differ only in their family have equal returns: the oracle reads the position.
    """
    oracle, env = Oracle.of(task), NavigationVectorEnv([task] * len(seeds))
    env.reset(seed=list(seeds))
    returns, going = np.zeros(len(seeds)), np.ones(len(seeds), dtype=np.bool_)
    while going.any():
        actions = np.zeros((len(seeds), 2), dtype=np.float32)
        positions = env.save_states()["position"]
        for index in np.flatnonzero(going):
            actions[index] = oracle.act(positions[index])
        _, rewards, terminated, truncated, _ = env.step(actions)
        returns[going] += rewards[going]
        going &= ~(terminated | truncated)
    return returns
