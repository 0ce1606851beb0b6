"""The oracle: it knows the map and reaches the goal without a collision in the fewest steps of a fine
plan."""

from __future__ import annotations

import functools
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.tasks import Task
from gym_extensions.envs.navigation.compiled import compiled
from gym_extensions.envs.navigation.grid import CELL, GOAL_RADIUS, Arena, arena
from gym_extensions.envs.navigation.motion import MAX_SPEED, crosses, touches
from gym_extensions.envs.navigation.single import course

FINENESS = 2
"""Lattice points a unit in x and in y; they lie between the grid lines, never on one."""
WHOLE = int(MAX_SPEED)
REACH = WHOLE * FINENESS
"""Lattice points a step."""
SLACK = 1e-5
"""How far a planned step may go beyond ``MAX_SPEED``: float32 actions miss lattice points by 1e-7."""
UNREACHED = -1
NEVER = 32767


@compiled
def _next_open(following: Any, row: int, column: int) -> int:
    """The first point of the row, from a column on, that is still to be reached; shortens the chain."""
    last = column
    while following[row, last] != last:
        last = following[row, last]
    while following[row, column] != last:
        following[row, column], column = last, following[row, column]
    return last


@compiled
def steps_to_go(solid: Any, goal_x: float, goal_y: float) -> Any:
    """The fewest steps to the goal from every lattice point by way of lattice points; −1 where there is no
    way.

    Breadth-first from the goal's disc. A step is any displacement of at most 5 units in x and in y whose
    segment is free. Entry [j, i] belongs to the point ((i + ½) / FINENESS, (j + ½) / FINENESS).
    """
    height = int((solid.shape[0] - 2) * CELL) * FINENESS
    width = int((solid.shape[1] - 2) * CELL) * FINENESS
    steps = np.full((height, width), UNREACHED, dtype=np.int16)
    queue = np.empty((height * width, 2), dtype=np.int32)
    # following[row, column] leads towards the next point of the row that is still to be reached.
    following = np.empty((height, width + 1), dtype=np.int32)
    first, last = 0, 0
    for row in range(height):
        following[row, width] = width
        for column in range(width):
            x, y = (column + 0.5) / FINENESS, (row + 0.5) / FINENESS
            following[row, column] = column
            if touches(solid, x, y):
                following[row, column] = column + 1
            elif (x - goal_x) ** 2 + (y - goal_y) ** 2 <= GOAL_RADIUS**2:
                steps[row, column], following[row, column] = 0, column + 1
                queue[last] = row, column
                last += 1
    while first < last:
        row, column = queue[first]
        first += 1
        x, y = (column + 0.5) / FINENESS, (row + 0.5) / FINENESS
        for to_row in range(max(row - REACH, 0), min(row + REACH + 1, height)):
            to_column = _next_open(following, to_row, max(column - REACH, 0))
            while to_column <= column + REACH and to_column < width:
                if not crosses(solid, x, y, (to_column + 0.5) / FINENESS, (to_row + 0.5) / FINENESS):
                    steps[to_row, to_column] = steps[row, column] + 1
                    following[to_row, to_column] = to_column + 1
                    queue[last] = to_row, to_column
                    last += 1
                to_column = _next_open(following, to_row, to_column + 1)
    return steps


@compiled
def _look(  # noqa: PLR0917
    solid: Any, steps: Any, goal: Any, x: float, y: float, at_most: int
) -> tuple[int, int, int, int]:
    """What is known at a free point: steps to go, how many next lattice points hold that, the first of them.

    The more of them there are, the deeper the point lies among those with as many steps to go. Gives
    ``NEVER`` if there are more steps to go than ``at_most``.
    """
    if (x - goal[0]) ** 2 + (y - goal[1]) ** 2 <= GOAL_RADIUS**2:
        return 0, 0, 0, 0
    height, width = steps.shape
    reach = (MAX_SPEED + SLACK) * FINENESS
    at_x, at_y = x * FINENESS - 0.5, y * FINENESS - 0.5
    fewest, count, best_row, best_column = NEVER, 0, 0, 0
    for row in range(max(math.ceil(at_y - reach), 0), min(math.floor(at_y + reach) + 1, height)):
        for column in range(max(math.ceil(at_x - reach), 0), min(math.floor(at_x + reach) + 1, width)):
            total = steps[row, column] + 1
            if total == UNREACHED + 1 or total > fewest or total > at_most:
                continue
            if crosses(solid, x, y, (column + 0.5) / FINENESS, (row + 0.5) / FINENESS):
                continue
            if total < fewest:
                fewest, count, best_row, best_column = total, 0, row, column
            count += 1
    return fewest, count, best_row, best_column


@compiled
def _try(  # noqa: PLR0917
    solid: Any, steps: Any, goal: Any, point: Any, move: Any, at_most: int
) -> tuple[int, int]:
    """As ``_look`` after a move: steps to go and their count; ``NEVER`` after a collision."""
    to_x, to_y = point[0] + move[0], point[1] + move[1]
    if crosses(solid, point[0], point[1], to_x, to_y):
        return NEVER, 0
    fewest, count, _, _ = _look(solid, steps, goal, to_x, to_y, at_most)
    return fewest, count


@compiled
def choose(solid: Any, steps: Any, goal: Any, point: Any, action: Any) -> None:
    """Writes the best displacement, float32, from a free point into ``action``.

    Tried are all whole displacements, which keep the point's place relative to the lattice and so lose
    nothing to rounding, and the step to the best lattice point. The latter alone leaves one step less to go,
    so every action does, and the goal is reached.
    """
    _, _, row, column = _look(solid, steps, goal, point[0], point[1], NEVER)
    to_x, to_y = (column + 0.5) / FINENESS - point[0], (row + 0.5) / FINENESS - point[1]
    action[0] = min(max(to_x, -MAX_SPEED), MAX_SPEED)
    action[1] = min(max(to_y, -MAX_SPEED), MAX_SPEED)
    best, most = _try(solid, steps, goal, point, action, NEVER)
    move = np.zeros(2, dtype=np.float32)
    for along_y in range(-WHOLE, WHOLE + 1):
        for along_x in range(-WHOLE, WHOLE + 1):
            move[0], move[1] = along_x, along_y
            after, count = _try(solid, steps, goal, point, move, best)
            if after < best or (after == best and count > most):
                best, most = after, count
                action[0], action[1] = along_x, along_y


class Oracle:
    """The plan for one arena; acts on positions, which it is told.

    From every free point it reaches the goal without a collision in at most ``steps_from(point)`` steps. It
    plans over points half a unit apart, so a way that rounds corners more tightly may be a step shorter.
    """

    def __init__(self, place: Arena) -> None:
        self.arena = place
        self._goal = np.array(place.goal)
        self.steps: NDArray[np.int16] = steps_to_go(place.grid.solid, place.goal[0], place.goal[1])

    @classmethod
    @functools.cache
    def of(cls, task: Task) -> Oracle:
        """The oracle of a navigation task; the same for all families of one map and goal."""
        drawn = course(task)
        return cls.at(drawn.map, drawn.goal)

    @classmethod
    @functools.cache
    def at(cls, map_number: int, goal_number: int) -> Oracle:
        """The oracle of a published map and goal, planned once a process."""
        return cls(arena(map_number, goal_number))

    def act(self, position: NDArray[np.float64]) -> NDArray[np.float32]:
        """The displacement from a free position (2,), in units."""
        action = np.zeros(2, dtype=np.float32)
        choose(self.arena.grid.solid, self.steps, self._goal, position, action)
        return action

    def steps_from(self, position: NDArray[np.float64]) -> int:
        """A number of steps in which the goal is surely reached from a free position (2,)."""
        return int(_look(self.arena.grid.solid, self.steps, self._goal, position[0], position[1], NEVER)[0])
