"""Occupancy grids and goals, read from the package's text files."""

from __future__ import annotations

import csv
import functools
import io
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import files

import numpy as np
from numpy.typing import NDArray

CELL = 10.0
"""Side of a cell, in units."""
COLUMNS, ROWS = 64, 48
WIDTH, HEIGHT = COLUMNS * CELL, ROWS * CELL
MAPS, GOALS = 10, 3
GOAL_RADIUS = 20.0
AGENT_RADIUS = 5.0
"""Radius of the disc that is drawn; the agent itself is a point."""
OBSTACLE, FREE = "#", "."


@dataclass(frozen=True, eq=False)
class Grid:
    """An occupancy grid with 1 for an obstacle.

    Cell ``(row, column)`` is ``solid[row + 1, column + 1]``, and row 0 is the map's bottom.

    The array has a ring of obstacles around the map, because everything outside the map is solid.
    """

    solid: NDArray[np.uint8]

    @property
    def cells(self) -> NDArray[np.bool_]:
        """The map without the ring, (rows, columns), True for an obstacle. Row 0 is the bottom."""
        return self.solid[1:-1, 1:-1].astype(np.bool_)

    @property
    def size(self) -> tuple[float, float]:
        """Width and height in units."""
        rows, columns = self.solid.shape
        return (columns - 2) * CELL, (rows - 2) * CELL


@dataclass(frozen=True, eq=False)
class Arena:
    """A grid and the center of the goal on it, in units."""

    grid: Grid
    goal: tuple[float, float]


def parse(lines: Sequence[str]) -> Grid:
    """Returns the grid of lines of ``#`` and ``.``, the first line at the top.

    Raises:
        ValueError: the lines differ in length or contain another character.
    """
    if not lines or any(len(line) != len(lines[0]) or set(line) - {OBSTACLE, FREE} for line in lines):
        raise ValueError(f"a map is lines of equal length made of {OBSTACLE!r} and {FREE!r}")
    drawn = np.array(
        [[character == OBSTACLE for character in line] for line in reversed(lines)], dtype=np.uint8
    )
    return Grid(np.pad(drawn, 1, constant_values=1))


def draw(cells: NDArray[np.bool_]) -> str:
    """Returns the text of a map file. Row 0 of the cells is at the bottom."""
    return "".join("".join(OBSTACLE if cell else FREE for cell in row) + "\n" for row in cells[::-1])


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
        for row in csv.DictReader(io.StringIO(text))
    }


def arena(map_number: int, goal_number: int) -> Arena:
    """Returns the published map with one of its three goals."""
    return Arena(load(map_number), goals()[map_number, goal_number])
