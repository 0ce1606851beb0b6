"""Vector environments: seeds, time limits, autoreset and infos of environments that are stepped together."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from gymnasium.spaces import Box
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from gym_extensions.catalog.tasks import Task
from gym_extensions.envs import interfaces
from gym_extensions.envs.interfaces import Array, Flags, Indices
from gym_extensions.errors import BenchError, whole_number

WHERE = "make_vec"
"""Where errors of vector environments are located."""


def seed_of_each(seed: Any, num_envs: int) -> Sequence[int | None]:
    """Returns the seed of every environment.

    None continues with the environment's generator. An int gives environment i the seed ``seed + i``, as in
    Gymnasium. A list is returned as it is.

    Raises:
        BenchError: the list does not have one seed per environment, or a seed is not a whole number of at
            least 0.
    """
    if seed is None:
        return [None] * num_envs
    if not isinstance(seed, Sequence | np.ndarray):
        first = whole_number("seed", seed, "bad-seeds", WHERE, least=0)
        return [first + index for index in range(num_envs)]
    if len(seed) != num_envs:
        hint = f"Give an int of at least 0, or a list of {num_envs}."
        raise BenchError("bad-seeds", f"seed is {seed!r}.", WHERE, hint)
    return [
        None if value is None else whole_number("seed", value, "bad-seeds", WHERE, least=0) for value in seed
    ]


def reset_mask(options: dict[str, Any] | None, num_envs: int) -> NDArray[np.bool_]:
    """Returns which environments to reset, ``(num_envs,)``, from the option ``reset_mask``, or all.

    Raises ``BenchError`` if the mask does not have one boolean per environment, or is all false.
    """
    mask = (options or {}).get("reset_mask")
    if mask is None:
        return np.ones(num_envs, np.bool_)
    chosen = np.asarray(mask)
    if chosen.shape != (num_envs,) or chosen.dtype != np.bool_ or not chosen.any():
        hint = f"Give {num_envs} booleans, at least one of them true."
        raise BenchError("bad-reset-mask", f"reset_mask is {mask!r}.", WHERE, hint)
    return chosen


Part = tuple[Indices, dict[str, NDArray[Any]]]
"""Environments with the same keys, in order, and their values by key, one row per environment."""


def select(parts: Iterable[Part], chosen: Flags) -> list[Part]:
    """Returns the parts without the environments that are not chosen, ``(num_envs,)``."""
    selected: list[Part] = []
    for members, values in parts:
        keep = chosen[members]
        if keep.any():
            selected.append((members[keep], {key: rows[keep] for key, rows in values.items()}))
    return selected


def combine(parts: Iterable[Part], num_envs: int) -> dict[str, Any]:
    """Returns the infos of parts of the environments, with zeros where an environment lacks a key."""
    infos: dict[str, Any] = {}
    for members, values in parts:
        for key, rows in values.items():
            if len(members) == num_envs:
                infos[key], infos[f"_{key}"] = rows.copy(), np.ones(num_envs, np.bool_)
                continue
            if key not in infos:
                infos[key] = np.zeros((num_envs, *rows.shape[1:]), rows.dtype)
                infos[f"_{key}"] = np.zeros(num_envs, np.bool_)
            infos[key][members] = rows
            infos[f"_{key}"][members] = True
    return infos


class TaskVectorEnv(VectorEnv[NDArray[Any], NDArray[Any], NDArray[Any]]):
    """Environments of tasks, stepped together. Every number is bit for bit the single environment's.

    Infos and autoreset modes are those of Gymnasium's ``SyncVectorEnv``: an environment whose episode ended
    is reset by the next step, which ignores its action and returns reward 0; by the same step, with
    ``final_obs`` and ``final_info`` in the infos; or by ``reset`` with the option ``reset_mask``.

    ``np_random`` is a generator for the user's own draws, which ``reset(seed=…)`` seeds; environments do not
    use it. Subclasses have the simulations. ``spaces`` are the observation and action space of one
    environment.
    """

    def __init__(self, tasks: Sequence[Task], spaces: tuple[Box, Box], autoreset_mode: AutoresetMode) -> None:
        self.tasks = tuple(tasks)
        self.num_envs = len(self.tasks)
        self.autoreset_mode = autoreset_mode
        self.metadata = {"autoreset_mode": autoreset_mode}
        self.single_observation_space, self.single_action_space = spaces
        self.observation_space = batch_space(spaces[0], self.num_envs)
        self.action_space = batch_space(spaces[1], self.num_envs)
        self._actions_shape = (self.num_envs, *spaces[1].shape)
        self._is_set = False
        self._limits = np.array([task.max_steps for task in self.tasks])
        self._elapsed = np.zeros(self.num_envs, np.int64)
        self._ended = np.zeros(self.num_envs, np.bool_)
        self._generators: list[np.random.Generator | None] = [None] * self.num_envs

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[Any], dict[str, Any]]:
        """Returns the observations, ``(num_envs, …)``, and the infos of the reset environments.

        Args:
            seed: an int gives environment i the seed ``seed + i``, as in Gymnasium; a list has one seed per
                environment (None continues with its generator).
            options: ``reset_mask``, ``(num_envs,)`` booleans: only these environments are reset. Others are
                ignored, as by Gymnasium's bodies.

        Raises:
            BenchError: seeds or mask are invalid. Nothing has changed then.
            ResetNeededError: the first reset leaves out environments.
        """
        interfaces.require_open(self.closed, WHERE)
        mask = reset_mask(options, self.num_envs)
        interfaces.require_reset(self._is_set or bool(mask.all()), WHERE)
        seeds = seed_of_each(seed, self.num_envs)
        for index in np.flatnonzero(mask).tolist():
            if seeds[index] is not None:
                self._generators[index], _ = seeding.np_random(seeds[index])
        if (given := next((value for value in seeds if value is not None), None)) is not None:
            self._np_random, self._np_random_seed = seeding.np_random(given)
        parts = self._start_episodes(mask)
        self._ended, self._is_set = self._ended & ~mask, True
        return self._observe(), combine(parts, self.num_envs)

    def step(self, actions: NDArray[Any]) -> tuple[NDArray[Any], Array, Flags, Flags, dict[str, Any]]:
        """Returns observations, rewards, terminations, truncations and infos of one step.

        Args:
            actions: ``(num_envs, act)``. MuJoCo bodies do not clip them and compute action costs in their
                precision; navigation clips them to ±5.

        Raises:
            BenchError: the shape differs, or a value is not a finite number.
            ResetNeededError: the environments were never reset, or an episode ended in mode DISABLED and its
                environment was not reset.
        """
        self._require_state()
        checked = np.ascontiguousarray(interfaces.check_actions(actions, self._actions_shape, WHERE))
        starting = self._ended if self._ended.any() else None
        if starting is not None and self.autoreset_mode is AutoresetMode.DISABLED:
            message = f"The episode of environment {np.flatnonzero(starting)[0]} has ended."
            hint = 'Call reset(options={"reset_mask": ...}) first.'
            raise interfaces.ResetNeededError("reset-needed", message, WHERE, hint)
        rewards, terminations = self._advance(checked, starting)
        parts = self._step_infos()
        self._elapsed += 1
        if starting is not None:
            parts = [*select(parts, ~starting), *self._start_episodes(starting)]
            rewards[starting], terminations[starting] = 0.0, False
        truncations = self._elapsed >= self._limits
        self._ended = terminations | truncations
        restarts = self.autoreset_mode is AutoresetMode.SAME_STEP and self._ended.any()
        infos = self._reset_in_same_step(parts) if restarts else combine(parts, self.num_envs)
        return self._observe(), rewards, terminations, truncations, infos

    def _reset_in_same_step(self, parts: Sequence[Part]) -> dict[str, Any]:
        """Starts new episodes where episodes have ended, and returns the infos of the step."""
        ended, last = self._ended, self._observe()
        final = combine(select(parts, ended), self.num_envs)
        final_obs = np.full(self.num_envs, None, dtype=object)
        for index in np.flatnonzero(ended).tolist():
            final_obs[index] = last[index]
        infos = combine([*select(parts, ~ended), *self._start_episodes(ended)], self.num_envs)
        self._ended = np.zeros(self.num_envs, np.bool_)
        last_step = {"final_obs": final_obs, "_final_obs": ended, "final_info": final, "_final_info": ended}
        return infos | last_step

    def _start_episodes(self, chosen: Flags) -> list[Part]:
        """Starts episodes in the chosen environments, and returns the infos of their resets."""
        self._start(chosen)
        self._elapsed[chosen] = 0
        return select(self._reset_infos(), chosen)

    def _require_state(self) -> None:
        interfaces.require_open(self.closed, WHERE)
        interfaces.require_reset(self._is_set, WHERE)

    def _start(self, chosen: Flags) -> None:
        """Draws and sets the states in which the chosen environments start, from their generators."""
        raise NotImplementedError

    def _advance(self, actions: NDArray[Any], resting: Flags | None) -> tuple[Array, Flags]:
        """Returns new arrays of rewards and terminations of one step. Rows of resting ones are ignored."""
        raise NotImplementedError

    def _observe(self) -> NDArray[Any]:
        """Returns a new array of observations, ``(num_envs, …)``."""
        raise NotImplementedError

    def _step_infos(self) -> list[Part]:
        """Returns the infos of the last step as new arrays. Rows of resting environments are ignored."""
        raise NotImplementedError

    def _reset_infos(self) -> list[Part]:
        """Returns the infos of a reset as new arrays. Rows of other environments are ignored."""
        return []

    def _generator(self, index: int) -> np.random.Generator:
        generator = self._generators[index]
        if generator is None:
            generator, _ = seeding.np_random()
            self._generators[index] = generator
        return generator

    def states(self) -> dict[str, Array]:
        """Returns copies of the states, ``(num_envs, …)`` by name.

        Of MuJoCo bodies ``qpos``, ``qvel``, ``time``, and ``mocap_pos`` and ``mocap_quat`` where a model has
        them (NaN in other rows); in navigation ``position``, in units.

        Raises:
            ResetNeededError: the environments were never reset.
        """
        raise NotImplementedError

    def call(self, name: str, *args: Any, **kwargs: Any) -> tuple[Any, ...]:
        """Returns the ``task`` of each environment. Raises ``BenchError`` for any other name."""
        if name != "task":
            raise BenchError("unknown-call", f"The environments have no {name!r}.", WHERE, "Call task.")
        return self.tasks

    def get_attr(self, name: str) -> tuple[Any, ...]:
        return self.call(name)
