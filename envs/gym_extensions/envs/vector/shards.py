"""All lanes of a vector environment as lots: what each lot gives, put together in the order of the lanes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gym_extensions.envs.vector.physics import Array, Lanes
from gym_extensions.envs.vector.registry import layout
from gym_extensions.envs.vector.rules import Flags
from gym_extensions.envs.vector.saved_state import check_names, rows_for
from gym_extensions.envs.vector.shard import Lot
from gym_extensions.envs.vector.template import Prototype


class Lots:
    """Lanes grouped by layout, in the order of each group's first lane; a single lot is passed through."""

    def __init__(self, lanes: Sequence[Prototype], num_threads: int) -> None:
        self._lanes = len(lanes)
        self._space = lanes[0].observation_space
        places: dict[tuple[object, ...], list[int]] = {}
        for place, lane in enumerate(lanes):
            places.setdefault(layout(lane), []).append(place)
        self._lots = [
            Lot(np.array(own), [lanes[place] for place in own], num_threads) for own in places.values()
        ]

    def reset(self, starting: Flags, generators: Sequence[np.random.Generator | None]) -> None:
        """Starts new episodes in the flagged lanes; those need a generator."""
        for lot in self._lots:
            lanes = np.flatnonzero(starting[lot.places])
            own = [generator for lane in lot.places[lanes] if (generator := generators[lane]) is not None]
            if len(lanes):
                lot.reset(lanes, own)

    def step(self, actions: NDArray[Any], resting: Flags | None) -> tuple[Array, Flags]:
        """Rewards and terminations of one step in every lane; the rows of resting ones mean nothing."""
        if len(self._lots) == 1:
            return self._lots[0].step(actions, None if resting is None else np.flatnonzero(~resting))
        rewards, terminations = np.empty(self._lanes), np.empty(self._lanes, np.bool_)
        for lot in self._lots:
            going = None if resting is None else np.flatnonzero(~resting[lot.places])
            rewards[lot.places], terminations[lot.places] = lot.step(actions[lot.places], going)
        return rewards, terminations

    def observe(self) -> Array:
        """A new array of every lane's observation."""
        if len(self._lots) == 1:
            return self._lots[0].observe()
        observations: Array = np.empty((self._lanes, *self._space.shape))
        for lot in self._lots:
            observations[lot.places] = lot.observe()
        return observations

    def save(self) -> dict[str, Array]:
        """Every lane's state by name; a name that some lanes lack holds NaN there."""
        if len(self._lots) == 1:
            return self._lots[0].save()
        states: dict[str, Array] = {}
        for lot in self._lots:
            for name, rows in lot.save().items():
                blank = np.full((self._lanes, *rows.shape[1:]), np.nan)
                states.setdefault(name, blank)[lot.places] = rows
        return states

    def save_each(self) -> list[dict[str, Array]]:
        """One state a lane, with the names that its task has."""
        states: list[dict[str, Array]] = [{} for _ in range(self._lanes)]
        for lot in self._lots:
            for name, rows in lot.save().items():
                for place, row in zip(lot.places, rows, strict=True):
                    states[place][name] = np.array(row)
        return states

    def load(self, lanes: Lanes, states: Mapping[str, Array]) -> None:
        """Puts rows of saved states into the given lanes, a row each.

        Raises:
            BenchError: a name is missing or unknown, a value has another shape or is not finite.
        """
        shapes = [lot.save() for lot in self._lots]
        check_names(states, set().union(*shapes))
        for lot, expected in zip(self._lots, shapes, strict=True):
            rows = np.flatnonzero(np.isin(lanes, lot.places))
            if len(rows):
                places = np.searchsorted(lot.places, lanes[rows])
                lot.load(places, rows_for(states, rows, expected))

    def close(self) -> None:
        """Lets threads and memory go."""
        for lot in self._lots:
            lot.close()
