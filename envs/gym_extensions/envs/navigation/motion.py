"""Points and segments against the closed cells of a grid, and the step of many agents."""

from __future__ import annotations

import math
from typing import Any

from gym_extensions.envs.navigation.grid import CELL, GOAL_RADIUS
from gym_extensions.envs.navigation.jit import compiled

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
def advance(  # noqa: PLR0917
    solids: Any,
    map_of: Any,
    goals: Any,
    positions: Any,
    actions: Any,
    waiting: Any,
    rewards: Any,
    reached: Any,
) -> None:
    """Moves every agent that is not waiting by its action, in place.

    Writes rewards and arrivals.

    Args:
        solids: (maps, rows + 2, columns + 2), as in ``Grid``; ``map_of`` (agents,) indexes it.
        goals: (agents, 2), in units; positions: (agents, 2), in units, changed in place.
        actions: (agents, 2), displacements in units; clipped here.
        waiting: (agents,), agents that stay where they are and get reward 0.
        rewards: (agents,), reached: (agents,); written.
    """
    for agent in range(len(positions)):
        rewards[agent], reached[agent] = 0.0, False
        if waiting[agent]:
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
