"""Exact distance and bearing of the closest obstacle of each agent."""

from __future__ import annotations

import math
from typing import Any

from gym_extensions.envs.navigation.grid import CELL
from gym_extensions.envs.navigation.jit import compiled


@compiled
def _closest(solid: Any, x: float, y: float) -> tuple[float, float]:
    """Distance and bearing to the closest obstacle. Of equally close points, the smallest bearing counts."""
    rows, columns = solid.shape
    home_column, home_row = int(x / CELL) + 1, int(y / CELL) + 1
    best, bearing = math.inf, math.inf
    ring = 0
    # Square rings of cells around the agent's own: nothing in ring k is closer than (k - 1) cells.
    while best == math.inf or best >= ((ring - 1) * CELL) ** 2:
        for row in range(max(home_row - ring, 0), min(home_row + ring, rows - 1) + 1):
            on_side = abs(row - home_row) == ring
            for column in range(
                home_column - ring, home_column + ring + 1, 1 if on_side or ring == 0 else 2 * ring
            ):
                if column < 0 or column >= columns or not solid[row, column]:
                    continue
                gap_x = max((column - 1) * CELL - x, 0.0) - max(x - column * CELL, 0.0)
                gap_y = max((row - 1) * CELL - y, 0.0) - max(y - row * CELL, 0.0)
                squared = gap_x * gap_x + gap_y * gap_y
                if squared <= best:
                    angle = math.atan2(gap_y, gap_x)
                    if squared < best or angle < bearing:
                        best, bearing = squared, angle
        ring += 1
    return math.sqrt(best), bearing


@compiled
def find_nearest(solids: Any, map_of: Any, positions: Any, observations: Any) -> None:
    """Writes distance (units) and bearing (rad, world frame, (−π, π]) into ``observations[:, 2:4]``."""
    for agent in range(len(positions)):
        distance, bearing = _closest(solids[map_of[agent]], positions[agent, 0], positions[agent, 1])
        observations[agent, 2], observations[agent, 3] = distance, bearing
