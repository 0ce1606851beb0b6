"""The navigation vector environment, with many agents in one compiled world."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.bodies.success import IS_SUCCESS
from gym_extensions.catalog.task import Task
from gym_extensions.envs.batch.engine import GeneratorOf
from gym_extensions.envs.batch.infos import Part
from gym_extensions.envs.batch.saved_states import check_names, rows_for
from gym_extensions.envs.batch.seeding import WHERE
from gym_extensions.envs.batch.vector_env import TaskVectorEnv
from gym_extensions.envs.navigation.env import course
from gym_extensions.envs.navigation.grid import arena
from gym_extensions.envs.navigation.observations import action_space, observation_space
from gym_extensions.envs.navigation.simulation import EXPECTED_STATE, World, whole_steps
from gym_extensions.envs.protocols import Array, Flags, Indices, States
from gym_extensions.errors import BenchError


class NavigationEngine:
    """Many agents of one navigation family, each alone in its arena."""

    def __init__(self, tasks: Sequence[Task], family: str) -> None:
        self._ids = [task.id for task in tasks]
        courses = [course(task) for task in tasks]
        self._world = World([arena(row.map, row.goal) for row in courses], family)
        self._nobody = np.zeros(len(tasks), np.bool_)
        self._steps = np.zeros(len(tasks), np.int64)
        self._arrivals = np.zeros(len(tasks), np.bool_)

    def check_options(self, options: Mapping[str, Any], indices: Indices) -> None:
        """Checks that ``start`` is a free point in these environments."""
        if "start" in options:
            for index in indices:
                self._world.free_point(int(index), options["start"], self._ids[index])

    def start(self, indices: Indices, generator: GeneratorOf, options: Mapping[str, Any]) -> None:
        """Places agents at the option ``start``, or at random."""
        self._steps[indices] = 0
        if "start" in options:
            self._world.positions[indices] = np.asarray(options["start"], np.float64)
            return
        for index in indices.tolist():
            self._world.draw_start(index, generator(index))

    def step(self, actions: NDArray[Any], resting: Flags | None) -> tuple[Array, Flags]:
        """Returns rewards and arrivals of one step; resting agents have reward 0."""
        self._steps += 1
        rewards, self._arrivals = self._world.advance(actions, self._nobody if resting is None else resting)
        return rewards, self._arrivals

    def observe(self) -> NDArray[Any]:
        """Returns a new array of observations, ``(num_envs, …)``."""
        return self._world.observe()

    def step_infos(self) -> list[Part]:
        """Returns ``is_success``: whether each agent arrived at its goal."""
        return [(np.arange(len(self._ids)), {IS_SUCCESS: self._arrivals.copy()})]

    def reset_infos(self) -> list[Part]:
        """There are no infos, as in the single environment."""
        return []

    def save(self) -> dict[str, Array]:
        """Returns ``position`` (num_envs, 2) in units and ``steps`` (num_envs,) since reset."""
        return {"position": self._world.positions.copy(), "steps": self._steps.astype(np.float64)}

    def save_each(self) -> list[dict[str, Array]]:
        """Returns one state per environment."""
        states = self.save()
        return [
            {name: np.array(rows[index]) for name, rows in states.items()} for index in range(len(self._ids))
        ]

    def load(self, indices: Indices, states: States) -> None:
        """Restores saved rows, all of them or none."""
        check_names(states, set(EXPECTED_STATE))
        expected = {name: value[None] for name, value in EXPECTED_STATE.items()}
        rows = rows_for(states, np.arange(len(indices)), expected)
        checked = [
            (self._world.free_point(index, position, self._ids[index]), whole_steps(steps, self._ids[index]))
            for index, position, steps in zip(indices.tolist(), rows["position"], rows["steps"], strict=True)
        ]
        for index, (position, steps) in zip(indices, checked, strict=True):
            self._world.positions[index], self._steps[index] = position, steps

    def close(self) -> None:
        """Nothing to free."""


class NavigationVectorEnv(TaskVectorEnv):
    """Navigation environments of one family.

    Args:
        tasks: the task of each environment.

    Raises:
        BenchError: the tasks belong to several families, or one is not a navigation task.
    """

    def __init__(self, tasks: Sequence[Task]) -> None:
        families = sorted({course(task).family for task in tasks})
        if len(families) > 1:
            message = f"The tasks have different observations: {', '.join(families)}."
            raise BenchError("different-spaces", message, WHERE, "Give tasks of one navigation family.")
        spaces = observation_space(families[0]), action_space()
        super().__init__(tasks, spaces, NavigationEngine(tasks, families[0]))
