"""Draws a task from above, with a background that is drawn once and the agent's disc over it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gym_extensions.envs.navigation.geometry import AGENT_RADIUS, GOAL_RADIUS, Arena, compiled, touches

FREE_COLOR, OBSTACLE_COLOR = (255, 255, 255), (204, 153, 102)
GOAL_COLOR = (255, 0, 0)
"""The agent's disc is black: the compiled code writes zeros."""


@compiled
def _in_obstacles(solid: Any, x: Any, y: Any) -> Any:
    """Which points of a lattice are in an obstacle, (len(y), len(x))."""
    inside = np.zeros((len(y), len(x)), dtype=np.bool_)
    for row in range(len(y)):
        for column in range(len(x)):
            inside[row, column] = touches(solid, x[column], y[row])
    return inside


def background(arena: Arena, pixel: float) -> NDArray[np.uint8]:
    """Draws the map and the goal's disc without an agent, (height / pixel, width / pixel, 3).

    A pixel shows what is at its center. The first row is the top of the map. ``pixel`` is its side in units.
    """
    width, height = arena.grid.size
    x = (np.arange(round(width / pixel)) + 0.5) * pixel
    y = height - (np.arange(round(height / pixel)) + 0.5) * pixel
    picture = np.empty((len(y), len(x), 3), dtype=np.uint8)
    picture[:] = FREE_COLOR
    picture[_in_obstacles(arena.grid.solid, x, y)] = OBSTACLE_COLOR
    goal_x, goal_y = arena.goal
    picture[(x[None, :] - goal_x) ** 2 + (y[:, None] - goal_y) ** 2 <= GOAL_RADIUS**2] = GOAL_COLOR
    return picture


@compiled
def _disc(picture: Any, x: float, y: float, pixel: float) -> None:
    """Colors the pixels whose centers are in the agent's disc black."""
    rows, columns, _ = picture.shape
    left, right = x - AGENT_RADIUS, x + AGENT_RADIUS
    top, bottom = rows * pixel - y - AGENT_RADIUS, rows * pixel - y + AGENT_RADIUS
    for row in range(max(math.floor(top / pixel), 0), min(math.ceil(bottom / pixel), rows)):
        for column in range(max(math.floor(left / pixel), 0), min(math.ceil(right / pixel), columns)):
            gap_x, gap_y = (column + 0.5) * pixel - x, (rows - row - 0.5) * pixel - y
            if gap_x * gap_x + gap_y * gap_y <= AGENT_RADIUS * AGENT_RADIUS:
                picture[row, column] = 0


@compiled
def draw_agents(pictures: Any, positions: Any, pixel: float) -> None:
    """Draws each agent's disc at its position in units into its background (agents, rows, columns, 3)."""
    for agent in range(len(positions)):
        _disc(pictures[agent], positions[agent, 0], positions[agent, 1], pixel)
