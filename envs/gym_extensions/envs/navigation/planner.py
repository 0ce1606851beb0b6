"""The fewest steps to a goal, and an oracle that takes them."""

import functools
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.tasks import Task
from gym_extensions.envs.interfaces import Flags
from gym_extensions.envs.navigation import geometry
from gym_extensions.envs.navigation.env import NavigationVectorEnv, course
from gym_extensions.envs.navigation.geometry import CELL, GOAL_RADIUS, MAX_SPEED, crosses, touches
from gym_extensions.envs.rollout import run_episodes
from gym_extensions.files import compiled

FINENESS = 2
"""Lattice points per unit in x and in y; they lie between the grid lines, never on one."""
WHOLE = int(MAX_SPEED)
REACH = WHOLE * FINENESS
"""Lattice points per step."""
SLACK = 1e-5
"""How far a planned step may go beyond ``MAX_SPEED``: float32 actions miss lattice points by 1e-7."""
UNREACHED = -1
NEVER = 32767


@compiled
def _next_open(following: Any, row: int, column: int) -> int:
    """The first point of the row, from a column on, that is still to be reached. Shortens the chain."""
    last = column
    while following[row, last] != last:
        last = following[row, last]
    while following[row, column] != last:
        following[row, column], column = last, following[row, column]
    return last


@compiled
def steps_to_go(solid: Any, goal_x: float, goal_y: float) -> Any:
    """Returns the fewest steps to the goal from every lattice point over lattice points, −1 without a path.

    Breadth-first from the goal's disc. A step is any displacement of at most 5 units in x and in y whose
    segment is free. Element [j, i] belongs to the point ((i + ½) / FINENESS, (j + ½) / FINENESS).
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
def _straight(goal: Any, x: float, y: float) -> tuple[int, float, float]:
    """Steps straight to the goal's disc were nothing in the way, and where they lead."""
    gap_x, gap_y = goal[0] - x, goal[1] - y
    steps = max(1, math.ceil((max(abs(gap_x), abs(gap_y)) - GOAL_RADIUS) / MAX_SPEED))
    while True:
        left_x, left_y = max(abs(gap_x) - MAX_SPEED * steps, 0.0), max(abs(gap_y) - MAX_SPEED * steps, 0.0)
        # A little inside the disc, for each step to come, since each misses its end a little.
        if left_x * left_x + left_y * left_y <= (GOAL_RADIUS - SLACK * steps) ** 2:
            return steps, goal[0] - math.copysign(left_x, gap_x), goal[1] - math.copysign(left_y, gap_y)
        steps += 1


@compiled
def lookahead(  # noqa: PLR0917
    solid: Any, steps: Any, goal: Any, x: float, y: float, at_most: int
) -> tuple[int, int, float, float]:
    """Returns the steps to go from a free point, the number of best next lattice points, and the next x, y.

    The more best points there are, the farther the point is from those with more steps to go. There is
    none if only the straight path to the goal, between lattice points, is that short. The steps are
    ``NEVER`` if there are more than ``at_most``.
    """
    if (x - goal[0]) ** 2 + (y - goal[1]) ** 2 <= GOAL_RADIUS**2:
        return 0, 0, x, y
    height, width = steps.shape
    reach = (MAX_SPEED + SLACK) * FINENESS
    at_x, at_y = x * FINENESS - 0.5, y * FINENESS - 0.5
    fewest, count, to_x, to_y = NEVER, 0, x, y
    for row in range(max(math.ceil(at_y - reach), 0), min(math.floor(at_y + reach) + 1, height)):
        for column in range(max(math.ceil(at_x - reach), 0), min(math.floor(at_x + reach) + 1, width)):
            total = steps[row, column] + 1
            if total == UNREACHED + 1 or total > fewest or total > at_most:
                continue
            if crosses(solid, x, y, (column + 0.5) / FINENESS, (row + 0.5) / FINENESS):
                continue
            if total < fewest:
                fewest, count = total, 0
                to_x, to_y = (column + 0.5) / FINENESS, (row + 0.5) / FINENESS
            count += 1
    steps_on, end_x, end_y = _straight(goal, x, y)
    if steps_on == fewest - 1 and not crosses(solid, x, y, end_x, end_y):
        return steps_on, 0, x + (end_x - x) / steps_on, y + (end_y - y) / steps_on
    return fewest, count, to_x, to_y


@compiled
def _try(solid: Any, steps: Any, goal: Any, point: Any, move: Any, at_most: int) -> tuple[int, int]:  # noqa: PLR0917
    """Steps to go and their count after a move, as ``lookahead`` returns them; ``NEVER`` if it collides."""
    to_x, to_y = point[0] + move[0], point[1] + move[1]
    if crosses(solid, point[0], point[1], to_x, to_y):
        return NEVER, 0
    fewest, count, _, _ = lookahead(solid, steps, goal, to_x, to_y, at_most)
    return fewest, count


@compiled
def choose(solid: Any, steps: Any, goal: Any, point: Any, action: Any) -> None:
    """Writes the best displacement, float32, from a free point into ``action``.

    Candidates are all integer displacements, which keep the point's offset from the lattice and so lose
    nothing to rounding, and the step that ``lookahead`` returns. That step alone leaves one step less to go,
    so the best candidate does too, and the goal is reached.
    """
    _, _, to_x, to_y = lookahead(solid, steps, goal, point[0], point[1], NEVER)
    action[0] = min(max(to_x - point[0], -MAX_SPEED), MAX_SPEED)
    action[1] = min(max(to_y - point[1], -MAX_SPEED), MAX_SPEED)
    best, most = _try(solid, steps, goal, point, action, NEVER)
    move = np.zeros(2, dtype=np.float32)
    for along_y in range(-WHOLE, WHOLE + 1):
        for along_x in range(-WHOLE, WHOLE + 1):
            move[0], move[1] = along_x, along_y
            after, count = _try(solid, steps, goal, point, move, best + 1)
            if after < best or (after == best and count > most):
                best, most = after, count
                action[0], action[1] = along_x, along_y


class Oracle:
    """The plan for one arena. It acts on the agent's position.

    From every free point it reaches the goal without a collision. It plans over points half a unit apart, so
    a path that rounds corners more tightly may be a step shorter.
    """

    def __init__(self, arena: geometry.Arena) -> None:
        self.arena = arena
        self._goal = np.array(arena.goal)
        self.steps: NDArray[np.int16] = steps_to_go(arena.grid.solid, arena.goal[0], arena.goal[1])

    @classmethod
    @functools.cache
    def at(cls, map_number: int, goal_number: int) -> "Oracle":
        """Returns the oracle of a published map and goal, planned once per process."""
        return cls(geometry.arena(map_number, goal_number))

    def act(self, position: NDArray[np.float64]) -> NDArray[np.float32]:
        """Returns the displacement from a free position (2,), in units."""
        action = np.zeros(2, dtype=np.float32)
        choose(self.arena.grid.solid, self.steps, self._goal, position, action)
        return action


def oracle_returns(task: Task, seeds: Sequence[int]) -> NDArray[np.float64]:
    """Returns the oracle's return in one episode per reset seed, (seeds,).

    Tasks that differ only in their family have equal returns: the oracle reads the position.
    """
    found, env = course(task), NavigationVectorEnv([task] * len(seeds))
    oracle = Oracle.at(found.map, found.goal)

    def act(observations: NDArray[Any], starts: Flags, running: Flags) -> NDArray[np.float32]:
        actions = np.zeros((len(seeds), 2), dtype=np.float32)
        positions = env.states()["position"]
        for index in np.flatnonzero(running):
            actions[index] = oracle.act(positions[index])
        return actions

    return np.array([outcome.return_ for outcome in run_episodes(env, seeds, act)])
