"""The vector environment over lots of lanes: seeds, time limits, autoreset."""

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
from gym_extensions.envs.seeding import WHERE, reset_mask, seed_of_each
from gym_extensions.envs.vector.physics import Array, Lanes
from gym_extensions.envs.vector.rules import Flags
from gym_extensions.envs.vector.shards import Lots
from gym_extensions.envs.vector.template import Prototype
from gym_extensions.errors import BenchError


class BatchVectorEnv(gym.vector.VectorEnv[Array, NDArray[Any], NDArray[Any]]):
    """Lanes of MuJoCo tasks stepped at once; every number is bit for bit the single environment's.

    Infos are empty. A lane whose episode ended is reset by the next step, which ignores its action and gives
    reward 0 (autoreset NEXT_STEP).
    """

    def __init__(self, lanes: Sequence[Prototype], num_threads: int) -> None:
        self.num_envs = len(lanes)
        self.metadata = {"autoreset_mode": AutoresetMode.NEXT_STEP}
        self.tasks: tuple[Task, ...] = tuple(lane.task for lane in lanes)
        self.single_observation_space = lanes[0].observation_space
        self.single_action_space = lanes[0].action_space
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self._actions_shape = (self.num_envs, *lanes[0].action_space.shape)
        self._lots = Lots(lanes, num_threads)
        self._limits = np.array([task.max_steps for task in self.tasks])
        self._elapsed = np.zeros(self.num_envs, np.int64)
        self._ended = np.zeros(self.num_envs, np.bool_)
        self._generators: list[np.random.Generator | None] = [None] * self.num_envs
        self._seeds: list[int | None] = [None] * self.num_envs

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """First observations, ``(lanes, …)``.

        Args:
            seed: an int, spawned into one seed a lane; or a seed a lane, with which it starts as the single
                environment does (None goes on with the lane's generator).
            options: ``reset_mask``, booleans over lanes, resets those alone.

        Raises:
            BenchError: there are not as many seeds or booleans as lanes.
        """
        chosen = reset_mask(options, self.num_envs)
        for lane, own in enumerate(seed_of_each(seed, self.num_envs)):
            if own is not None and chosen[lane]:
                self._generators[lane], self._seeds[lane] = seeding.np_random(own)
        self._begin(chosen)
        self._ended = self._ended & ~chosen
        return self._lots.observe(), {}

    def step(self, actions: NDArray[Any]) -> tuple[Array, Array, Flags, Flags, dict[str, Any]]:
        """Observations, rewards, terminations, truncations of one step in every lane; infos are empty.

        Args:
            actions: ``(lanes, act)``; not clipped, in the precision in which costs are then computed.

        Raises:
            BenchError: another shape, or a value that is not a finite number.
        """
        given = check_actions(actions, self._actions_shape, WHERE)
        starting = self._ended if self._ended.any() else None
        rewards, terminations = self._lots.step(given, starting)
        self._elapsed += 1
        if starting is not None:
            self._begin(starting)
            rewards[starting] = 0.0
            terminations[starting] = False
        truncations = self._elapsed >= self._limits
        self._ended = terminations | truncations
        return self._lots.observe(), rewards, terminations, truncations, {}

    def _begin(self, starting: Flags) -> None:
        self._elapsed[starting] = 0
        for lane in np.flatnonzero(starting):
            self._generator(int(lane))
        self._lots.reset(starting, self._generators)

    def _generator(self, lane: int) -> np.random.Generator:
        generator = self._generators[lane]
        if generator is None:
            generator, self._seeds[lane] = seeding.np_random()
            self._generators[lane] = generator
        return generator

    def save_states(self) -> dict[str, Array]:
        """Every lane's state as the single environment's ``save_state`` names it, ``(lanes, …)``.

        A name that some lanes lack (their tasks carry other values) holds NaN there.
        """
        return self._lots.save()

    def restore_states(self, states: dict[str, Array], lanes: Sequence[int] | Lanes | None = None) -> Array:
        """Puts saved rows into the given lanes (all, in order, if None) and gives every lane's observation.

        Step counts start from 0 there, and the lanes do not count as ended.

        Args:
            states: arrays by name, a row for each of the given lanes; ``derived_`` names may be absent.
            lanes: indices of lanes.

        Raises:
            BenchError: a name is missing or unknown, a value has another shape or is not finite.
        """
        chosen = np.arange(self.num_envs) if lanes is None else np.asarray(lanes, np.intp)
        self._lots.load(chosen, states)
        self._elapsed[chosen] = 0
        self._ended[chosen] = False
        return self._lots.observe()

    def call(self, name: str, *args: Any, **kwargs: Any) -> tuple[Any, ...]:
        """What single environments would answer: ``save_state``, ``task``, ``np_random``, ``np_random_seed``.

        Raises:
            BenchError: any other name, or arguments.
        """
        answers: dict[str, Callable[[], Iterable[Any]]] = {
            "save_state": self._lots.save_each,
            "task": lambda: self.tasks,
            "np_random": lambda: map(self._generator, range(self.num_envs)),
            "np_random_seed": lambda: self._seeds,
        }
        if name not in answers or args or kwargs:
            hint = f"They answer {', '.join(answers)}, without arguments."
            raise BenchError("unknown-call", f"Lanes do not answer {name!r}.", WHERE, hint)
        return tuple(answers[name]())

    def get_attr(self, name: str) -> tuple[Any, ...]:
        """The same as ``call`` without arguments."""
        return self.call(name)

    def close_extras(self, **kwargs: Any) -> None:
        """Lets threads and memory go."""
        self._lots.close()
