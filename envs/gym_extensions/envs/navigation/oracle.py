"""It knows the map, and reaches the goal without a collision by the fewest steps of a fine plan."""

from __future__ import annotations

import functools
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.task import Task
from gym_extensions.envs.navigation.env import course
from gym_extensions.envs.navigation.grid import Arena, arena
from gym_extensions.envs.navigation.planner import NEVER, choose, look, steps_to_go
from gym_extensions.envs.navigation.vector_env import NavigationVector


class Oracle:
    """The plan for one arena; acts on positions, which it is told.

    From every free point it reaches the goal without a collision in at most ``steps_from(point)`` steps. It
    plans over points half a unit apart, so a way that rounds corners more tightly may be a step shorter.
    """

    def __init__(self, place: Arena) -> None:
        self.arena = place
        self._goal = np.array(place.goal)
        self.steps: NDArray[np.int16] = steps_to_go(place.grid.solid, place.goal[0], place.goal[1])

    @classmethod
    @functools.cache
    def of(cls, task: Task) -> Oracle:
        """The oracle of a navigation task; the same for all families of one map and goal."""
        drawn = course(task)
        return cls.at(drawn.map, drawn.goal)

    @classmethod
    @functools.cache
    def at(cls, map_number: int, goal_number: int) -> Oracle:
        """The oracle of a published map and goal, planned once a process."""
        return cls(arena(map_number, goal_number))

    def act(self, position: NDArray[np.float64]) -> NDArray[np.float32]:
        """The displacement from a free position (2,), in units."""
        action = np.zeros(2, dtype=np.float32)
        choose(self.arena.grid.solid, self.steps, self._goal, position, action)
        return action

    def steps_from(self, position: NDArray[np.float64]) -> int:
        """A number of steps in which the goal is surely reached from a free position (2,)."""
        return int(look(self.arena.grid.solid, self.steps, self._goal, position[0], position[1], NEVER)[0])


def oracle_returns(task: Task, seeds: Sequence[int]) -> NDArray[np.float64]:
    """The oracle's return in the episode that starts from each reset seed, shape (seeds,).

    The family of the task makes no difference: the oracle is told where it is.
    """
    oracle, env = Oracle.of(task), NavigationVector([task] * len(seeds))
    env.reset(seed=list(seeds))
    returns, going = np.zeros(len(seeds)), np.ones(len(seeds), dtype=np.bool_)
    while going.any():
        actions = np.zeros((len(seeds), 2), dtype=np.float32)
        positions = env.save_states()["position"]
        for lane in np.flatnonzero(going):
            actions[lane] = oracle.act(positions[lane])
        _, rewards, terminated, truncated, _ = env.step(actions)
        returns[going] += rewards[going]
        going &= ~(terminated | truncated)
    return returns
