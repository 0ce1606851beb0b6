"""Ranges to the closed cells of a grid along sixteen beams, by exact ray–grid intersection."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from gym_extensions.envs.navigation.grid import CELL
from gym_extensions.envs.navigation.jit import compiled

BEAMS = 16
MAX_RANGE = 100.0

# Square roots are rounded the same way on every machine, cosines are not; and the two components of a beam at
# 45° are the same number, so that a ray through corners meets both grid lines at the same range.
_DIAGONAL = math.sqrt(0.5)
_LONG, _SHORT = math.sqrt(2 + math.sqrt(2)) / 2, math.sqrt(2 - math.sqrt(2)) / 2
_COSINES = (1.0, _LONG, _DIAGONAL, _SHORT)
_SINES = (0.0, _SHORT, _DIAGONAL, _LONG)
DIRECTIONS = np.array(
    [
        (cosine * turn_x - sine * turn_y, cosine * turn_y + sine * turn_x)
        for turn_x, turn_y in ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))
        for cosine, sine in zip(_COSINES, _SINES, strict=True)
    ]
)
"""Unit vectors of the beams in the world frame, (16, 2): beam i at 22.5°·i counter-clockwise from +x."""
_QUARTER = BEAMS // 4
_AXIS = tuple((int(x), int(y)) for x, y in DIRECTIONS[::_QUARTER])
"""The beams along the grid."""
_EAST, _NORTH = DIRECTIONS[:, 0] > 0, DIRECTIONS[:, 1] > 0
_ALONG = np.abs(np.where(DIRECTIONS == 0.0, 1.0, DIRECTIONS))
_PER_X, _PER_Y = 1.0 / _ALONG[:, 0], 1.0 / _ALONG[:, 1]
"""Range per unit of progress in x and in y; not used for the beams along the grid."""


@compiled
def _straight(solid: Any, x: float, y: float, step_x: int, step_y: int) -> float:
    """The range along a grid axis. A ray that runs on a grid line touches the cells on both sides of it."""
    low_row, high_row = math.ceil(y / CELL), math.floor(y / CELL) + 1
    low_column, high_column = math.ceil(x / CELL), math.floor(x / CELL) + 1
    if step_x != 0:
        column = high_column if step_x > 0 else low_column
        while True:
            column += step_x
            distance = (column - 1) * CELL - x if step_x > 0 else x - column * CELL
            if distance >= MAX_RANGE:
                return MAX_RANGE
            if solid[low_row, column] or solid[high_row, column]:
                return distance
    row = high_row if step_y > 0 else low_row
    while True:
        row += step_y
        distance = (row - 1) * CELL - y if step_y > 0 else y - row * CELL
        if distance >= MAX_RANGE:
            return MAX_RANGE
        if solid[row, low_column] or solid[row, high_column]:
            return distance


@compiled
def _oblique(  # noqa: PLR0917
    cells: Any, cell: Any, gap_x: float, gap_y: float, step_x: Any, step_y: Any, per_x: float, per_y: float
) -> float:
    """The range along a direction that is not along the grid, computed from grid line to grid line.

    Args:
        cells: the grid, row after row; ``cell`` is the ray's first, ``step_x`` and ``step_y`` lead on from
            it.
        gap_x, gap_y: distances to the first grid lines ahead, in units.
        per_x, per_y: range per unit of progress in x and in y.
    """
    next_x, next_y = gap_x * per_x, gap_y * per_y
    gap_x, gap_y = gap_x + CELL, gap_y + CELL
    while True:
        if next_x < next_y:
            distance, cell = next_x, cell + step_x
            next_x, gap_x = gap_x * per_x, gap_x + CELL
        elif next_y < next_x:
            distance, cell = next_y, cell + step_y
            next_y, gap_y = gap_y * per_y, gap_y + CELL
        else:
            # Through a corner: it belongs to the two cells beside the ray as well.
            distance = next_x
            if distance < MAX_RANGE and (cells[cell + step_x] or cells[cell + step_y]):
                return distance
            cell = cell + step_x + step_y
            next_x, gap_x = gap_x * per_x, gap_x + CELL
            next_y, gap_y = gap_y * per_y, gap_y + CELL
        if distance >= MAX_RANGE:
            return MAX_RANGE
        if cells[cell]:
            return distance


@compiled
def cast_ranges(solids: Any, map_of: Any, positions: Any, ranges: Any) -> None:
    """Writes every agent's ranges, in units, into ``ranges[:, :16]``.

    A beam without a hit is ``MAX_RANGE``.

    Args:
        solids, map_of, positions: as in ``motion.advance``; every position is free.
    """
    stride = solids.shape[2]
    for agent in range(len(positions)):
        solid = solids[map_of[agent]]
        cells = solid.reshape(-1)
        x, y = positions[agent, 0], positions[agent, 1]
        column, row = int(x / CELL) + 1, int(y / CELL) + 1
        # Unsigned: otherwise every look-up would first check for a negative index.
        cell = np.uint64(row * stride + column)
        west, south = x - (column - 1) * CELL, y - (row - 1) * CELL
        east, north = column * CELL - x, row * CELL - y
        for beam in range(BEAMS):
            if beam % _QUARTER == 0:
                step_x, step_y = _AXIS[beam // _QUARTER]
                ranges[agent, beam] = _straight(solid, x, y, step_x, step_y)
                continue
            gap_x, step_x = (east, 1) if _EAST[beam] else (west, -1)
            gap_y, step_y = (north, stride) if _NORTH[beam] else (south, -stride)
            ranges[agent, beam] = _oblique(
                cells, cell, gap_x, gap_y, np.uint64(step_x), np.uint64(step_y), _PER_X[beam], _PER_Y[beam]
            )
