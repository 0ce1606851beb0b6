"""The MuJoCo vector environment, with seeds, time limits and autoreset."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from gym_extensions.catalog.task import Task
from gym_extensions.envs.actions import check_actions
from gym_extensions.envs.protocols import Array, Flags, Indices
from gym_extensions.envs.seeding import WHERE, reset_mask, seed_of_each
from gym_extensions.envs.vector.shards import Shards
from gym_extensions.envs.vector.template import TaskTemplate
from gym_extensions.errors import BenchError


class MujocoVectorEnv(gym.vector.VectorEnv[Array, NDArray[Any], NDArray[Any]]):
    """MuJoCo environments stepped together.

    Every number is bit for bit the single environment's.

    Infos of steps have ``is_success`` where tasks define success, as SyncVectorEnv's do. An environment whose
    episode ended is reset by the next step, which ignores its action and returns reward 0 (autoreset
    NEXT_STEP).
    """

    def __init__(self, templates: Sequence[TaskTemplate], num_threads: int) -> None:
        self.num_envs = len(templates)
        self.metadata = {"autoreset_mode": AutoresetMode.NEXT_STEP}
        self.tasks: tuple[Task, ...] = tuple(template.task for template in templates)
        self.single_observation_space = templates[0].observation_space
        self.single_action_space = templates[0].action_space
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self._actions_shape = (self.num_envs, *templates[0].action_space.shape)
        self._shards = Shards(templates, num_threads)
        self._limits = np.array([task.max_steps for task in self.tasks])
        self._elapsed = np.zeros(self.num_envs, np.int64)
        self._ended = np.zeros(self.num_envs, np.bool_)
        self._generators: list[np.random.Generator | None] = [None] * self.num_envs
        self._seeds: list[int | None] = [None] * self.num_envs

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Returns the first observations, ``(num_envs, …)``, and an empty dictionary.

        Args:
            seed: an int, spawned into one seed per environment; or one seed per environment, with which it
                starts as the single environment does (None continues with its generator).
            options: ``reset_mask``, ``(num_envs,)`` booleans: only these environments are reset.

        Raises:
            BenchError: the number of seeds or booleans differs from ``num_envs``.
        """
        chosen = reset_mask(options, self.num_envs)
        for index, value in enumerate(seed_of_each(seed, self.num_envs)):
            if value is not None and chosen[index]:
                self._generators[index], self._seeds[index] = seeding.np_random(value)
        self._begin(chosen)
        self._ended = self._ended & ~chosen
        return self._shards.observe(), {}

    def step(self, actions: NDArray[Any]) -> tuple[Array, Array, Flags, Flags, dict[str, Any]]:
        """Returns observations, rewards, terminations, truncations and infos of one step.

        Args:
            actions: ``(num_envs, act)``; not clipped; action costs are computed in their precision.

        Raises:
            BenchError: the shape differs, or a value is not a finite number.
        """
        checked = check_actions(actions, self._actions_shape, WHERE)
        starting = self._ended if self._ended.any() else None
        rewards, terminations = self._shards.step(checked, starting)
        self._elapsed += 1
        if starting is not None:
            self._begin(starting)
            rewards[starting] = 0.0
            terminations[starting] = False
        truncations = self._elapsed >= self._limits
        self._ended = terminations | truncations
        infos = self._shards.infos(starting)
        return self._shards.observe(), rewards, terminations, truncations, infos

    def _begin(self, starting: Flags) -> None:
        self._elapsed[starting] = 0
        for index in np.flatnonzero(starting):
            self._generator(int(index))
        self._shards.reset(starting, self._generators)

    def _generator(self, index: int) -> np.random.Generator:
        generator = self._generators[index]
        if generator is None:
            generator, self._seeds[index] = seeding.np_random()
            self._generators[index] = generator
        return generator

    def save_states(self) -> dict[str, Array]:
        """Returns the states, ``(num_envs, …)`` by the names of the single environment's ``save_state``.

        A name that some environments lack, because their tasks have other values, has NaN in their rows.
        """
        return self._shards.save()

    def restore_states(
        self, states: dict[str, Array], indices: Sequence[int] | Indices | None = None
    ) -> Array:
        """Restores saved rows and returns the observations of all environments.

        The time limits of the restored environments start again at 0.

        Args:
            states: arrays by name, one row per restored environment; ``derived_`` names may be absent.
            indices: the environments to restore; None for all, in order.

        Raises:
            BenchError: a name is missing or unknown, or a value has another shape or is not finite.
        """
        chosen = np.arange(self.num_envs) if indices is None else np.asarray(indices, np.intp)
        self._shards.load(chosen, states)
        self._elapsed[chosen] = 0
        self._ended[chosen] = False
        return self._shards.observe()

    def call(self, name: str, *args: Any, **kwargs: Any) -> tuple[Any, ...]:
        """Returns one value of ``save_state``, ``task``, ``np_random`` or ``np_random_seed`` per environment.

        Raises:
            BenchError: another name, or arguments.
        """
        answers: dict[str, Callable[[], Iterable[Any]]] = {
            "save_state": self._shards.save_each,
            "task": lambda: self.tasks,
            "np_random": lambda: map(self._generator, range(self.num_envs)),
            "np_random_seed": lambda: self._seeds,
        }
        if name not in answers or args or kwargs:
            hint = f"Call one of {', '.join(answers)}, without arguments."
            raise BenchError("unknown-call", f"The environments have no {name!r}.", WHERE, hint)
        return tuple(answers[name]())

    def get_attr(self, name: str) -> tuple[Any, ...]:
        """Same as ``call`` without arguments."""
        return self.call(name)

    def close_extras(self, **kwargs: Any) -> None:
        """Frees threads and memory."""
        self._shards.close()
