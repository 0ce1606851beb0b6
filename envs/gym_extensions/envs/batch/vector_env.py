"""Seeds, time limits, autoreset, saved states and infos of environments that are stepped together."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.spaces import Box
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from gym_extensions.catalog.task import Task
from gym_extensions.envs.actions import check_actions
from gym_extensions.envs.batch.engine import Engine
from gym_extensions.envs.batch.infos import combine, gather, select
from gym_extensions.envs.batch.saved_states import check_rows
from gym_extensions.envs.batch.seeding import WHERE, check_indices, reset_mask, seed_of_each
from gym_extensions.envs.lifecycle import IndependentCopies, require_open, require_reset
from gym_extensions.envs.protocols import Array, Flags, Indices, States
from gym_extensions.errors import BenchError


class TaskVectorEnv(gym.vector.VectorEnv[NDArray[Any], NDArray[Any], NDArray[Any]], IndependentCopies):
    """Environments of tasks, stepped together. Every number is bit for bit the single environment's.

    Infos are those of the single environments in the form of Gymnasium's vector environments. An environment
    whose episode ended is reset by the next step, which ignores its action and returns reward 0 (autoreset
    NEXT_STEP). Copies and pickles continue exactly where the original is.

    Args:
        tasks: the task of each environment.
        spaces: the observation and action space of one environment.
        engine: the simulations.
    """

    def __init__(self, tasks: Sequence[Task], spaces: tuple[Box, Box], engine: Engine) -> None:
        self.tasks = tuple(tasks)
        self.num_envs = len(self.tasks)
        self.metadata = {"autoreset_mode": AutoresetMode.NEXT_STEP}
        self.single_observation_space, self.single_action_space = spaces
        self.observation_space = batch_space(spaces[0], self.num_envs)
        self.action_space = batch_space(spaces[1], self.num_envs)
        self._actions_shape = (self.num_envs, *spaces[1].shape)
        self._engine = engine
        self._is_set = False
        self._limits = np.array([task.max_steps for task in self.tasks])
        self._elapsed = np.zeros(self.num_envs, np.int64)
        self._ended = np.zeros(self.num_envs, np.bool_)
        self._everyone = np.ones(self.num_envs, np.bool_)
        self._everyone.flags.writeable = False
        self._generators: list[np.random.Generator | None] = [None] * self.num_envs
        self._seeds: list[int | None] = [None] * self.num_envs

    def __getstate__(self) -> dict[str, Any]:
        """Returns the attributes. Raises ``ClosedError`` after ``close``."""
        require_open(self.closed, WHERE)
        return self.__dict__.copy()

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[Any], dict[str, Any]]:
        """Returns the observations, ``(num_envs, …)``, and the infos of the reset environments.

        Args:
            seed: an int gives environment i the seed ``seed + i``, as in Gymnasium; a list has one seed per
                environment (None continues with its generator).
            options: ``reset_mask``, ``(num_envs,)`` booleans: only these environments are reset. Navigation
                accepts ``start``, a point (x, y) in units that is free in every environment.

        Raises:
            BenchError: seeds, mask or start are invalid. Nothing has changed then.
            ResetNeededError: the first reset leaves out environments.
        """
        require_open(self.closed, WHERE)
        mask = reset_mask(options, self.num_envs)
        require_reset(self._is_set or bool(mask.all()), WHERE)
        seeds, indices = seed_of_each(seed, self.num_envs), np.flatnonzero(mask)
        self._engine.check_options(options or {}, indices)
        for index in indices.tolist():
            if seeds[index] is not None:
                self._generators[index], self._seeds[index] = seeding.np_random(seeds[index])
        self._start(indices, options or {})
        self._ended, self._is_set = self._ended & ~mask, True
        parts = self._engine.reset_infos()
        infos = gather(parts, self._everyone) if mask.all() else combine(select(parts, mask), self.num_envs)
        return self._engine.observe(), infos

    def step(self, actions: NDArray[Any]) -> tuple[NDArray[Any], Array, Flags, Flags, dict[str, Any]]:
        """Returns observations, rewards, terminations, truncations and infos of one step.

        Args:
            actions: ``(num_envs, act)``. MuJoCo bodies do not clip them and compute action costs in their
                precision; navigation clips them to ±5.

        Raises:
            BenchError: the shape differs, or a value is not a finite number.
            ResetNeededError: the environments were never reset.
        """
        if self.closed or not self._is_set:
            self._require_state()
        checked = np.ascontiguousarray(check_actions(actions, self._actions_shape, WHERE))
        starting = self._ended if self._ended.any() else None
        rewards, terminations = self._engine.step(checked, starting)
        parts = self._engine.step_infos()
        self._elapsed += 1
        if starting is None:
            infos = gather(parts, self._everyone)
        else:
            self._start(np.flatnonzero(starting), {})
            rewards[starting] = 0.0
            terminations[starting] = False
            parts = [*select(parts, ~starting), *select(self._engine.reset_infos(), starting)]
            infos = combine(parts, self.num_envs)
        truncations = self._elapsed >= self._limits
        self._ended = terminations | truncations
        return self._engine.observe(), rewards, terminations, truncations, infos

    def _require_state(self) -> None:
        require_open(self.closed, WHERE)
        require_reset(self._is_set, WHERE)

    def _start(self, indices: Indices, options: Mapping[str, Any]) -> None:
        self._engine.start(indices, self._generator, options)
        self._elapsed[indices] = 0

    def _generator(self, index: int) -> np.random.Generator:
        generator = self._generators[index]
        if generator is None:
            generator, self._seeds[index] = seeding.np_random()
            self._generators[index] = generator
        return generator

    def save_states(self) -> dict[str, Array]:
        """Returns the states, ``(num_envs, …)`` by the names of the single environment's ``save_state``.

        A name that some environments lack, because their tasks have other values, has NaN in their rows.

        Raises:
            ResetNeededError: the environments were never reset.
        """
        self._require_state()
        return self._engine.save()

    def restore_states(self, states: States, indices: Sequence[int] | Indices | None = None) -> NDArray[Any]:
        """Restores saved rows and returns the observations of all environments.

        The time limits of the restored environments start again at 0.

        Args:
            states: arrays by name, one row per restored environment; ``derived_`` names may be absent.
            indices: the environments to restore; None for all, in order.

        Raises:
            BenchError: a name is missing or unknown, a value is invalid, or an index is out of range. Nothing
                has changed then.
            ResetNeededError: the environments were never reset, and not all are restored.
        """
        require_open(self.closed, WHERE)
        chosen = check_indices(indices, self.num_envs)
        require_reset(self._is_set or len(chosen) == self.num_envs, WHERE)
        check_rows(states, len(chosen))
        self._engine.load(chosen, states)
        self._elapsed[chosen] = 0
        self._ended[chosen] = False
        self._is_set = True
        return self._engine.observe()

    def call(self, name: str, *args: Any, **kwargs: Any) -> tuple[Any, ...]:
        """Returns one value of ``save_state``, ``task``, ``np_random`` or ``np_random_seed`` per environment.

        Raises:
            BenchError: another name, or arguments.
            ResetNeededError: ``save_state`` of environments that were never reset.
            ClosedError: the environments are closed.
        """
        answers: dict[str, Callable[[], Iterable[Any]]] = {
            "save_state": self._engine.save_each,
            "task": lambda: self.tasks,
            "np_random": lambda: map(self._generator, range(self.num_envs)),
            "np_random_seed": lambda: self._seeds,
        }
        if name not in answers or args or kwargs:
            hint = f"Call one of {', '.join(answers)}, without arguments."
            raise BenchError("unknown-call", f"The environments have no {name!r}.", WHERE, hint)
        require_open(self.closed, WHERE)
        if name == "save_state":
            self._require_state()
        return tuple(answers[name]())

    def get_attr(self, name: str) -> tuple[Any, ...]:
        """Same as ``call`` without arguments."""
        return self.call(name)

    def close_extras(self, **kwargs: Any) -> None:
        """Frees threads and memory."""
        self._engine.close()
