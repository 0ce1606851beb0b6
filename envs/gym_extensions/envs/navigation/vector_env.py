"""The navigation vector environment, with many agents in one compiled world."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from gym_extensions.catalog.task import Task
from gym_extensions.envs.actions import check_actions
from gym_extensions.envs.navigation.env import course
from gym_extensions.envs.navigation.grid import arena
from gym_extensions.envs.navigation.observations import action_space, observation_space
from gym_extensions.envs.navigation.simulation import World
from gym_extensions.envs.protocols import Array, Flags, Indices, States
from gym_extensions.envs.seeding import WHERE, reset_mask, seed_of_each
from gym_extensions.envs.success import success_infos
from gym_extensions.errors import BenchError


class NavigationVectorEnv(gym.vector.VectorEnv[NDArray[Any], NDArray[Any], NDArray[Any]]):
    """Navigation environments of one family, bit for bit the single environments.

    Infos of steps have ``is_success``, as SyncVectorEnv's do.

    An environment whose episode ended is reset by the next step, which ignores its action and returns
    reward 0 (autoreset NEXT_STEP).

    Args:
        tasks: the task of each environment.

    Raises:
        BenchError: the tasks belong to several families, or one is not a navigation task.
    """

    def __init__(self, tasks: Sequence[Task]) -> None:
        self.tasks = tuple(tasks)
        self.num_envs = len(self.tasks)
        self.metadata = {"autoreset_mode": AutoresetMode.NEXT_STEP}
        courses = [course(task) for task in self.tasks]
        families = sorted({row.family for row in courses})
        if len(families) > 1:
            message = f"The tasks have different observations: {', '.join(families)}."
            raise BenchError("different-spaces", message, WHERE, "Give tasks of one navigation family.")
        self.single_observation_space = observation_space(families[0])
        self.single_action_space = action_space()
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self._world = World([arena(row.map, row.goal) for row in courses], families[0])
        self._limits = np.array([task.max_steps for task in self.tasks])
        self._steps = np.zeros(self.num_envs, np.int64)
        self._elapsed = np.zeros(self.num_envs, np.int64)
        self._ended = np.zeros(self.num_envs, np.bool_)
        self._generators: list[np.random.Generator | None] = [None] * self.num_envs
        self._seeds: list[int | None] = [None] * self.num_envs

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[Any], dict[str, Any]]:
        """Returns the first observations, ``(num_envs, …)``, and an empty dictionary.

        Args:
            seed: an int, spawned into one seed per environment; or one seed per environment, with which it
                starts as the single environment does (None continues with its generator).
            options: ``start``, a point (x, y) in units that is free in every environment; ``reset_mask``,
                ``(num_envs,)`` booleans: only these environments are reset.

        Raises:
            BenchError: the start or mask is invalid, or the number of seeds differs from ``num_envs``.
        """
        chosen = reset_mask(options, self.num_envs)
        for index, value in enumerate(seed_of_each(seed, self.num_envs)):
            if value is not None and chosen[index]:
                self._generators[index], self._seeds[index] = seeding.np_random(value)
        self._begin(chosen, options or {})
        self._ended[chosen] = False
        return self._world.observe(), {}

    def step(self, actions: NDArray[Any]) -> tuple[NDArray[Any], Array, Flags, Flags, dict[str, Any]]:
        """Returns observations, rewards, terminations, truncations and infos of one step.

        Args:
            actions: ``(num_envs, 2)``, displacements in units, clipped to ±5.

        Raises:
            BenchError: the shape differs, or a value is not a finite number.
        """
        checked = check_actions(actions, (self.num_envs, 2), WHERE)
        starting = self._ended
        rewards, terminations = self._world.advance(checked, starting)
        self._steps += 1
        self._elapsed += 1
        if starting.any():
            self._begin(starting, {})
        truncations = self._elapsed >= self._limits
        self._ended = terminations | truncations
        infos = success_infos(terminations, ~starting)
        return self._world.observe(), rewards, terminations, truncations, infos

    def save_states(self) -> dict[str, Array]:
        """Returns the states, ``(num_envs, …)`` by the names of the single environment's ``save_state``."""
        return {"position": self._world.positions.copy(), "steps": self._steps.astype(np.float64)}

    def restore_states(self, states: States, indices: Sequence[int] | Indices | None = None) -> NDArray[Any]:
        """Restores saved rows and returns the observations of all environments.

        The time limits of the restored environments start again at 0.

        Args:
            states: ``position`` and ``steps``, one row per restored environment.
            indices: the environments to restore; None for all, in order.

        Raises:
            BenchError: a position is not free.
        """
        chosen = range(self.num_envs) if indices is None else indices
        for row, index in enumerate(chosen):
            self._world.place(int(index), states["position"][row], self.tasks[index].id)
            self._steps[index] = int(states["steps"][row])
            self._elapsed[index], self._ended[index] = 0, False
        return self._world.observe()

    def call(self, name: str, *args: Any, **kwargs: Any) -> tuple[Any, ...]:
        """Returns one value of ``save_state``, ``task``, ``np_random`` or ``np_random_seed`` per environment.

        Raises:
            BenchError: another name, or arguments.
        """
        names = ("save_state", "task", "np_random", "np_random_seed")
        if name not in names or args or kwargs:
            hint = f"Call one of {', '.join(names)}, without arguments."
            raise BenchError("unknown-call", f"The environments have no {name!r}.", WHERE, hint)
        if name == "task":
            return self.tasks
        if name == "save_state":
            states = self.save_states()
            return tuple(
                {key: np.array(rows[index]) for key, rows in states.items()} for index in range(self.num_envs)
            )
        return (
            tuple(self._seeds)
            if name == "np_random_seed"
            else tuple(map(self._generator, range(self.num_envs)))
        )

    def get_attr(self, name: str) -> tuple[Any, ...]:
        """Same as ``call`` without arguments."""
        return self.call(name)

    def _begin(self, starting: Flags, options: Mapping[str, Any]) -> None:
        self._steps[starting] = self._elapsed[starting] = 0
        for index in map(int, np.flatnonzero(starting)):
            if "start" in options:
                self._world.place(index, options["start"], self.tasks[index].id)
            else:
                self._world.draw_start(index, self._generator(index))

    def _generator(self, index: int) -> np.random.Generator:
        generator = self._generators[index]
        if generator is None:
            generator, self._seeds[index] = seeding.np_random()
            self._generators[index] = generator
        return generator
