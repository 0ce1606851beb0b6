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

from gym_extensions.catalog.errors import BenchError
from gym_extensions.catalog.tasks import Task
from gym_extensions.envs.actions import check_actions
from gym_extensions.envs.batching.lot import Lot, layout
from gym_extensions.envs.batching.physics import Array, Lanes
from gym_extensions.envs.batching.prototype import Prototype
from gym_extensions.envs.batching.rules import Flags
from gym_extensions.envs.batching.seeds import lane_seeds

WHERE = "make_batch"


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
        self._lots = _lots(lanes, num_threads)
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
            BenchError: as many seeds as lanes are needed.
        """
        chosen = self._chosen(options)
        for lane, lane_seed in enumerate(self._spread(seed)):
            if lane_seed is not None and chosen[lane]:
                self._generators[lane], self._seeds[lane] = seeding.np_random(lane_seed)
        self._begin(chosen)
        self._ended[chosen] = False
        return self._observe(), {}

    def _chosen(self, options: dict[str, Any] | None) -> Flags:
        mask = (options or {}).get("reset_mask")
        if mask is None:
            return np.ones(self.num_envs, np.bool_)
        chosen = np.asarray(mask)
        if chosen.shape != (self.num_envs,) or chosen.dtype != np.bool_ or not chosen.any():
            hint = f"Give {self.num_envs} booleans, at least one of them true."
            raise BenchError("bad-reset-mask", f"reset_mask is {mask!r}.", WHERE, hint)
        return chosen

    def _spread(self, seed: int | Sequence[int | None] | None) -> Sequence[int | None]:
        if seed is None:
            return [None] * self.num_envs
        if isinstance(seed, int | np.integer):
            return lane_seeds(int(seed), self.num_envs)
        if len(seed) != self.num_envs:
            hint = "Give one seed a lane, or one int for all."
            raise BenchError(
                "bad-seeds", f"There are {len(seed)} seeds for {self.num_envs} lanes.", WHERE, hint
            )
        return seed

    def step(self, actions: NDArray[Any]) -> tuple[Array, Array, Flags, Flags, dict[str, Any]]:
        """Observations, rewards, terminations, truncations of one step in every lane; infos are empty.

        Args:
            actions: ``(lanes, act)``; not clipped, in the precision in which costs are then computed.

        Raises:
            BenchError: another shape, or a value that is not a finite number.
        """
        given = check_actions(actions, self._actions_shape, WHERE)
        starting = self._ended
        some_start = bool(starting.any())
        rewards, terminations = self._advance(given, starting if some_start else None)
        self._elapsed += 1
        if some_start:
            self._begin(starting)
            rewards[starting] = 0.0
            terminations[starting] = False
        truncations = self._elapsed >= self._limits
        self._ended = terminations | truncations
        return self._observe(), rewards, terminations, truncations, {}

    def _advance(self, actions: NDArray[Any], starting: Flags | None) -> tuple[Array, Flags]:
        if len(self._lots) == 1:
            return self._lots[0].step(actions, None if starting is None else np.flatnonzero(~starting))
        rewards, terminations = np.empty(self.num_envs), np.empty(self.num_envs, np.bool_)
        for lot in self._lots:
            going = None if starting is None else np.flatnonzero(~starting[lot.places])
            rewards[lot.places], terminations[lot.places] = lot.step(actions[lot.places], going)
        return rewards, terminations

    def _begin(self, lanes: Flags) -> None:
        self._elapsed[lanes] = 0
        for lot in self._lots:
            starting = np.flatnonzero(lanes[lot.places])
            if len(starting):
                lot.reset(starting, [self._generator(int(lot.places[lane])) for lane in starting])

    def _generator(self, lane: int) -> np.random.Generator:
        generator = self._generators[lane]
        if generator is None:
            generator, self._seeds[lane] = seeding.np_random()
            self._generators[lane] = generator
        return generator

    def _observe(self) -> Array:
        if len(self._lots) == 1:
            return self._lots[0].observe()
        space = self.single_observation_space
        observations = np.empty((self.num_envs, *(space.shape or ())), space.dtype)
        for lot in self._lots:
            observations[lot.places] = lot.observe()
        return observations

    def save_states(self) -> dict[str, Array]:
        """Every lane's state as the single environment's ``save_state`` names it, ``(lanes, …)``.

        A name that some lanes lack (their tasks carry other values) holds NaN there.
        """
        if len(self._lots) == 1:
            return self._lots[0].save()
        states: dict[str, Array] = {}
        for lot in self._lots:
            for name, rows in lot.save().items():
                blank = np.full((self.num_envs, *rows.shape[1:]), np.nan)
                states.setdefault(name, blank)[lot.places] = rows
        return states

    def restore_states(self, states: dict[str, Array], lanes: Sequence[int] | Lanes | None = None) -> Array:
        """Puts saved rows into the given lanes (all, in order, if None) and gives every lane's observation.

        Step counts start from 0 there, and the lanes do not count as ended.

        Args:
            states: arrays by name, a row for each of the given lanes; ``derived_`` names may be absent.
            lanes: indices of lanes.
        """
        chosen = np.arange(self.num_envs) if lanes is None else np.asarray(lanes, np.intp)
        for lot in self._lots:
            row_of = {int(lane): row for row, lane in enumerate(chosen)}
            here = [
                (place, row_of[int(lane)]) for place, lane in enumerate(lot.places) if int(lane) in row_of
            ]
            if here:
                places, rows = (np.array(part, np.intp) for part in zip(*here, strict=True))
                lot.load(places, {name: np.asarray(value)[rows] for name, value in states.items()})
        self._elapsed[chosen] = 0
        self._ended[chosen] = False
        return self._observe()

    def call(self, name: str, *args: Any, **kwargs: Any) -> tuple[Any, ...]:
        """What single environments would answer: ``save_state``, ``task``, ``np_random``, ``np_random_seed``.

        Raises:
            BenchError: any other name.
        """
        answers: dict[str, Callable[[], Iterable[Any]]] = {
            "save_state": self._saved,
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

    def _saved(self) -> list[dict[str, Array]]:
        answers: list[dict[str, Array]] = [{} for _ in range(self.num_envs)]
        for lot in self._lots:
            for name, rows in lot.save().items():
                for place, row in zip(lot.places, rows, strict=True):
                    answers[place][name] = np.array(row)
        return answers

    def close_extras(self, **kwargs: Any) -> None:
        """Lets threads and memory go."""
        for lot in self._lots:
            lot.close()


def _lots(lanes: Sequence[Prototype], num_threads: int) -> list[Lot]:
    """Lanes grouped by layout, in the order of each group's first lane."""
    places: dict[tuple[object, ...], list[int]] = {}
    for place, lane in enumerate(lanes):
        places.setdefault(layout(lane), []).append(place)
    return [Lot(np.array(own), [lanes[place] for place in own], num_threads) for own in places.values()]
