"""Occupancy grids, and points and segments against their closed cells."""

import csv
import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import files
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gym_extensions.files import compiled

CELL = 10.0
"""Side of a cell, in units."""
COLUMNS, ROWS = 64, 48
WIDTH, HEIGHT = COLUMNS * CELL, ROWS * CELL
GOAL_RADIUS = 20.0
AGENT_RADIUS = 5.0
"""Radius of the disc that is drawn; the agent itself is a point."""


@dataclass(frozen=True, eq=False)
class Grid:
    """An occupancy grid with 1 for an obstacle, in a ring of obstacles: everything outside the map is solid.

    Cell ``(row, column)`` is ``solid[row + 1, column + 1]``, and row 0 is the map's bottom.
    """

    solid: NDArray[np.uint8]

    @property
    def cells(self) -> NDArray[np.bool_]:
        """The map without the ring, (rows, columns), True for an obstacle. Row 0 is the bottom."""
        return self.solid[1:-1, 1:-1].astype(np.bool_)

    @property
    def size(self) -> tuple[float, float]:
        rows, columns = self.solid.shape
        return (columns - 2) * CELL, (rows - 2) * CELL


@dataclass(frozen=True, eq=False)
class Arena:
    """A grid and the center of the goal on it, in units."""

    grid: Grid
    goal: tuple[float, float]


def parse(lines: Sequence[str]) -> Grid:
    """Returns the grid of lines of ``#`` and ``.``, the first line at the top."""
    drawn = np.array([[character == "#" for character in line] for line in reversed(lines)], np.uint8)
    return Grid(np.pad(drawn, 1, constant_values=1))


def map_bytes(number: int) -> bytes:
    """Returns the bytes of a published map file."""
    return (files(__package__) / "maps" / f"map{number}.txt").read_bytes()


@functools.cache
def load(number: int) -> Grid:
    """Returns the published map of that number, 0 to 9."""
    return parse(map_bytes(number).decode("ascii").splitlines())


@functools.cache
def goals() -> dict[tuple[int, int], tuple[float, float]]:
    """Returns the center of every goal in units, by (map, goal)."""
    text = (files(__package__) / "maps" / "goals.csv").read_text(encoding="ascii")
    return {
        (int(row["map"]), int(row["goal"])): (float(row["x"]), float(row["y"]))
        for row in csv.DictReader(text.splitlines())
    }


@functools.cache
def arena(map_number: int, goal_number: int) -> Arena:
    """Returns the published map with one of its three goals."""
    return Arena(load(map_number), goals()[map_number, goal_number])


STEP_REWARD, COLLISION_REWARD, GOAL_REWARD = -1.0, -5.0, 10.0
MAX_SPEED = 5.0
"""Largest displacement per step in x and in y, in units."""


@compiled
def touches(solid: Any, x: float, y: float) -> bool:
    """Whether a point is in an obstacle, including its edges and corners, or outside the map."""
    rows, columns = solid.shape
    if not (0.0 < x < (columns - 2) * CELL and 0.0 < y < (rows - 2) * CELL):
        return True
    # A point on a grid line belongs to the cells on both sides of it.
    for row in range(math.ceil(y / CELL), math.floor(y / CELL) + 2):
        for column in range(math.ceil(x / CELL), math.floor(x / CELL) + 2):
            if solid[row, column]:
                return True
    return False


@compiled
def crosses(solid: Any, x: float, y: float, to_x: float, to_y: float) -> bool:
    """Whether a segment inside the map touches an obstacle, including its edges and corners.

    A cell that the segment's bounding box touches is touched by the segment unless all four corners lie
    strictly on one side of it.
    """
    along_x, along_y = to_x - x, to_y - y
    for row in range(math.ceil(min(y, to_y) / CELL), math.floor(max(y, to_y) / CELL) + 2):
        for column in range(math.ceil(min(x, to_x) / CELL), math.floor(max(x, to_x) / CELL) + 2):
            if solid[row, column]:
                left, right = (column - 1) * CELL - x, column * CELL - x
                below, above = (row - 1) * CELL - y, row * CELL - y
                a, b = along_x * below - along_y * left, along_x * below - along_y * right
                c, d = along_x * above - along_y * left, along_x * above - along_y * right
                if not (min(a, b, c, d) > 0.0 or max(a, b, c, d) < 0.0):
                    return True
    return touches(solid, to_x, to_y)


@compiled
def advance(solids: Any, map_of: Any, goals: Any, positions: Any, actions: Any, resting: Any) -> Any:  # noqa: PLR0917
    """Moves every agent that is not resting by its action, in place; returns rewards and arrivals, (agents,).

    Args:
        solids: (maps, rows + 2, columns + 2), as in ``Grid``; ``map_of`` (agents,) indexes it.
        goals: (agents, 2), in units; positions: (agents, 2), in units, changed in place.
        actions: (agents, 2), displacements in units; clipped here.
        resting: (agents,), agents that stay where they are and get reward 0.
    """
    rewards, reached = np.zeros(len(positions)), np.zeros(len(positions), np.bool_)
    for agent in range(len(positions)):
        if resting[agent]:
            continue
        solid = solids[map_of[agent]]
        x, y = positions[agent, 0], positions[agent, 1]
        to_x = x + min(max(actions[agent, 0], -MAX_SPEED), MAX_SPEED)
        to_y = y + min(max(actions[agent, 1], -MAX_SPEED), MAX_SPEED)
        reward = STEP_REWARD
        if crosses(solid, x, y, to_x, to_y):
            reward += COLLISION_REWARD
            to_x, to_y = x, y
        positions[agent, 0], positions[agent, 1] = to_x, to_y
        gap_x, gap_y = to_x - goals[agent, 0], to_y - goals[agent, 1]
        if gap_x * gap_x + gap_y * gap_y <= GOAL_RADIUS * GOAL_RADIUS:
            reward += GOAL_REWARD
            reached[agent] = True
        rewards[agent] = reward
    return rewards, reached
