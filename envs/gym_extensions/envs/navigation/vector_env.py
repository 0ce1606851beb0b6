"""The vector environment: many agents in one world."""

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
from gym_extensions.envs.seeding import WHERE, reset_mask, seed_of_each
from gym_extensions.errors import BenchError

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]


class NavigationVector(gym.vector.VectorEnv[NDArray[Any], NDArray[Any], NDArray[Any]]):
    """Lanes of navigation tasks of one family, bit for bit the single environments; infos are empty.

    A lane whose episode ended is reset by the next step, which ignores its action and gives reward 0
    (autoreset NEXT_STEP).

    Args:
        lanes: the task of each lane.

    Raises:
        BenchError: the tasks are of several families, or one is no navigation task.
    """

    def __init__(self, lanes: Sequence[Task]) -> None:
        self.tasks = tuple(lanes)
        self.num_envs = len(self.tasks)
        self.metadata = {"autoreset_mode": AutoresetMode.NEXT_STEP}
        courses = [course(task) for task in self.tasks]
        families = sorted({drawn.family for drawn in courses})
        if len(families) > 1:
            message = f"The lanes observe differently: {', '.join(families)}."
            raise BenchError("different-spaces", message, WHERE, "Give tasks of one navigation family.")
        self.single_observation_space = observation_space(families[0])
        self.single_action_space = action_space()
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self._world = World([arena(drawn.map, drawn.goal) for drawn in courses], families[0])
        self._limits = np.array([task.max_steps for task in self.tasks])
        self._steps = np.zeros(self.num_envs, np.int64)
        self._elapsed = np.zeros(self.num_envs, np.int64)
        self._ended = np.zeros(self.num_envs, np.bool_)
        self._generators: list[np.random.Generator | None] = [None] * self.num_envs
        self._seeds: list[int | None] = [None] * self.num_envs

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[Any], dict[str, Any]]:
        """First observations, ``(lanes, …)``.

        Args:
            seed: an int, spawned into one seed a lane; or a seed a lane, with which it starts as the single
                environment does (None goes on with the lane's generator).
            options: ``start``, a point (x, y) in units that is free for every lane; ``reset_mask``, booleans
                over lanes, resets those alone.

        Raises:
            BenchError: a bad start or mask, or not as many seeds as lanes.
        """
        chosen = reset_mask(options, self.num_envs)
        for lane, lane_seed in enumerate(seed_of_each(seed, self.num_envs)):
            if lane_seed is not None and chosen[lane]:
                self._generators[lane], self._seeds[lane] = seeding.np_random(lane_seed)
        self._begin(chosen, options or {})
        self._ended[chosen] = False
        return self._world.observe(), {}

    def step(self, actions: NDArray[Any]) -> tuple[NDArray[Any], Array, Flags, Flags, dict[str, Any]]:
        """Observations, rewards, terminations, truncations of one step in every lane; infos are empty.

        Args:
            actions: ``(lanes, 2)``, displacements in units, clipped to ±5.

        Raises:
            BenchError: another shape, or a value that is not a finite number.
        """
        given = check_actions(actions, (self.num_envs, 2), WHERE)
        starting = self._ended
        rewards, terminations = self._world.advance(given, starting)
        self._steps += 1
        self._elapsed += 1
        if starting.any():
            self._begin(starting, {})
        truncations = self._elapsed >= self._limits
        self._ended = terminations | truncations
        return self._world.observe(), rewards, terminations, truncations, {}

    def save_states(self) -> dict[str, Array]:
        """Every lane's state as the single environment's ``save_state`` names it, ``(lanes, …)``."""
        return {"position": self._world.positions.copy(), "steps": self._steps.astype(np.float64)}

    def restore_states(
        self, states: Mapping[str, Array], lanes: Sequence[int] | NDArray[np.intp] | None = None
    ) -> NDArray[Any]:
        """Puts saved rows into the given lanes (all, in order, if None) and gives every lane's observation.

        The time limit counts from 0 there, and the lanes do not count as ended.

        Raises:
            BenchError: a position is not free.
        """
        chosen = range(self.num_envs) if lanes is None else lanes
        for row, lane in enumerate(chosen):
            self._world.place(int(lane), states["position"][row], self.tasks[lane].id)
            self._steps[lane] = int(states["steps"][row])
            self._elapsed[lane], self._ended[lane] = 0, False
        return self._world.observe()

    def call(self, name: str, *args: Any, **kwargs: Any) -> tuple[Any, ...]:
        """What single environments would answer: ``save_state``, ``task``, ``np_random``, ``np_random_seed``.

        Raises:
            BenchError: any other name.
        """
        names = ("save_state", "task", "np_random", "np_random_seed")
        if name not in names or args or kwargs:
            hint = f"They answer {', '.join(names)}, without arguments."
            raise BenchError("unknown-call", f"Lanes do not answer {name!r}.", WHERE, hint)
        if name == "task":
            return self.tasks
        if name == "save_state":
            states = self.save_states()
            return tuple(
                {key: np.array(rows[lane]) for key, rows in states.items()} for lane in range(self.num_envs)
            )
        return (
            tuple(self._seeds)
            if name == "np_random_seed"
            else tuple(map(self._generator, range(self.num_envs)))
        )

    def get_attr(self, name: str) -> tuple[Any, ...]:
        """The same as ``call`` without arguments."""
        return self.call(name)

    def _begin(self, lanes: Flags, options: Mapping[str, Any]) -> None:
        self._steps[lanes] = self._elapsed[lanes] = 0
        for lane in map(int, np.flatnonzero(lanes)):
            if "start" in options:
                self._world.place(lane, options["start"], self.tasks[lane].id)
            else:
                self._world.draw_start(lane, self._generator(lane))

    def _generator(self, lane: int) -> np.random.Generator:
        generator = self._generators[lane]
        if generator is None:
            generator, self._seeds[lane] = seeding.np_random()
            self._generators[lane] = generator
        return generator
