"""Many agents, each alone in its arena, moved and observed together."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gym_extensions.envs.navigation.geometry import Arena, advance, touches
from gym_extensions.envs.navigation.rendering import background, move_agents
from gym_extensions.envs.navigation.sensors import BEAMS, FIELDS, PIXEL, cast_ranges, find_nearest
from gym_extensions.errors import BenchError

START_CLEARANCE = 100.0
"""Smallest distance of a random start from the goal, in units."""


class World:
    """The positions of many agents and what they observe, which is a key of the catalog's ``FAMILIES``.

    ``arenas`` are the grid and the goal of each agent; all grids have the same size.
    """

    def __init__(self, arenas: Sequence[Arena], family: str) -> None:
        self.arenas, self.family, count = tuple(arenas), family, len(arenas)
        grids = list(dict.fromkeys(arena.grid for arena in arenas))
        self._solids = np.stack([grid.solid for grid in grids])
        self._map_of = np.array([grids.index(arena.grid) for arena in arenas])
        self._goals = np.array([arena.goal for arena in arenas], dtype=np.float64)
        self.positions = np.full((count, 2), np.nan)
        self._rewards, self._reached = np.zeros(count), np.zeros(count, dtype=np.bool_)
        if family == "image":
            keys = [(number, arena.goal) for number, arena in zip(self._map_of.tolist(), arenas, strict=True)]
            distinct = dict(zip(keys, arenas, strict=True))
            self._backgrounds = np.stack([background(arena, PIXEL) for arena in distinct.values()])
            self._background_of = np.array([list(distinct).index(key) for key in keys])
            self._pictures, self._shown = self._backgrounds[self._background_of], np.full((count, 2), np.nan)
        else:
            width = sum(field.count for field in FIELDS[family])
            self._numbers = np.zeros((count, width), dtype=np.float32)
            if family in ("state-goal", "range-known"):
                self._numbers[:, -2:] = self._goals  # they never change

    def advance(
        self, actions: NDArray[Any], waiting: NDArray[np.bool_]
    ) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
        """Moves every agent that is not ``waiting`` (agents,); returns rewards and arrivals, (agents,) each.

        ``actions`` (agents, 2) are displacements in units, clipped here. Waiting agents get reward 0.
        """
        moves = np.ascontiguousarray(actions, dtype=np.float64)
        rewards, reached = self._rewards, self._reached
        advance(self._solids, self._map_of, self._goals, self.positions, moves, waiting, rewards, reached)
        return rewards.copy(), reached.copy()

    def observe(self) -> NDArray[Any]:
        """Returns every agent's observation, (agents, …). Every agent has been placed."""
        if self.family == "image":
            backgrounds = self._backgrounds, self._background_of
            move_agents(self._pictures, *backgrounds, self._shown, self.positions, PIXEL)
            return np.copy(self._pictures)
        numbers = self._numbers
        if self.family.startswith("range"):
            cast_ranges(self._solids, self._map_of, self.positions, numbers)
            if self.family == "range-known":
                numbers[:, BEAMS : BEAMS + 2] = self.positions
        else:
            numbers[:, :2] = self.positions
            find_nearest(self._solids, self._map_of, self.positions, numbers)
        return numbers.copy()

    def draw_start(self, agent: int, generator: np.random.Generator) -> None:
        """Places an agent uniformly over the free space that is far enough from its goal."""
        size, goal = self.arenas[agent].grid.size, self._goals[agent]
        while True:
            x, y = generator.uniform((0.0, 0.0), size)
            far = np.hypot(x - goal[0], y - goal[1]) >= START_CLEARANCE
            if far and not touches(self.arenas[agent].grid.solid, x, y):
                self.positions[agent] = x, y
                return

    def free_point(self, agent: int, point: Any, where: str) -> NDArray[np.float64]:
        """Returns a point on an agent's map as an array (2,), in units.

        Raises ``BenchError`` if the point is not two finite numbers, or is in an obstacle or outside the map.
        """
        width, height = self.arenas[agent].grid.size
        hint = f"Give (x, y) in free space, 0 < x < {width:g} and 0 < y < {height:g}."
        try:
            start = np.asarray(point, dtype=np.float64)
        except (TypeError, ValueError):
            start = np.array(np.nan)
        if start.shape != (2,) or not np.isfinite(start).all():
            raise BenchError("bad-start", f"The start is {point!r}, not two finite numbers.", where, hint)
        if touches(self.arenas[agent].grid.solid, start[0], start[1]):
            message = f"The start ({start[0]:g}, {start[1]:g}) is in an obstacle or outside the map."
            raise BenchError("bad-start", message, where, hint)
        return start
