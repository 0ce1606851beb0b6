"""What agents observe: the closest obstacle, ranges along beams, pictures from above, and the spaces."""

import math
from typing import Any

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from gym_extensions.catalog.descriptions import Field
from gym_extensions.envs.navigation import geometry
from gym_extensions.envs.navigation.geometry import AGENT_RADIUS, CELL, HEIGHT, WIDTH, touches
from gym_extensions.files import compiled


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
            stride = 1 if on_side or ring == 0 else 2 * ring
            for column in range(home_column - ring, home_column + ring + 1, stride):
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
_EAST, _NORTH = DIRECTIONS[:, 0] > 0, DIRECTIONS[:, 1] > 0
_ALONG = np.abs(np.where(DIRECTIONS == 0.0, 1.0, DIRECTIONS))
_PER_X, _PER_Y = 1.0 / _ALONG[:, 0], 1.0 / _ALONG[:, 1]
"""Range per unit of progress in x and in y; not used for the beams along the grid."""


@compiled
def _straight(solid: Any, along: float, across: float, step: int) -> float:
    """The range along a row of the grid. On a grid line, it touches the cells of both sides.

    ``along`` and ``across`` are x and y, in a transposed grid y and x; ``step`` is 1 or -1.
    """
    low, high = math.ceil(across / CELL), math.floor(across / CELL) + 1
    column = math.floor(along / CELL) + 1 if step > 0 else math.ceil(along / CELL)
    while True:
        column += step
        distance = (column - 1) * CELL - along if step > 0 else along - column * CELL
        if distance >= MAX_RANGE:
            return MAX_RANGE
        if solid[low, column] or solid[high, column]:
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
    """Writes every agent's ranges, in units, into ``ranges[:, :16]``; ``MAX_RANGE`` without a hit.

    The other arguments are as in ``geometry.advance``; every position is free.
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
            if beam % (BEAMS // 2) == 0:
                ranges[agent, beam] = _straight(solid, x, y, 1 if beam == 0 else -1)
                continue
            if beam % (BEAMS // 4) == 0:
                ranges[agent, beam] = _straight(solid.T, y, x, 1 if beam < BEAMS // 2 else -1)
                continue
            gap_x, step_x = (east, 1) if _EAST[beam] else (west, -1)
            gap_y, step_y = (north, stride) if _NORTH[beam] else (south, -stride)
            ranges[agent, beam] = _oblique(
                cells, cell, gap_x, gap_y, np.uint64(step_x), np.uint64(step_y), _PER_X[beam], _PER_Y[beam]
            )


PIXEL = 4.0
"""Side of a pixel of an image observation, in units."""
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


def background(arena: geometry.Arena, pixel: float) -> NDArray[np.uint8]:
    """Draws the map and over it the goal's disc, without an agent, (height / pixel, width / pixel, 3).

    A pixel shows what is at its center. The first row is the top of the map. ``pixel`` is its side in units.
    """
    width, height = arena.grid.size
    x = (np.arange(round(width / pixel)) + 0.5) * pixel
    y = height - (np.arange(round(height / pixel)) + 0.5) * pixel
    picture = np.empty((len(y), len(x), 3), dtype=np.uint8)
    picture[:] = FREE_COLOR
    picture[_in_obstacles(arena.grid.solid, x, y)] = OBSTACLE_COLOR
    goal_x, goal_y = arena.goal
    picture[(x[None, :] - goal_x) ** 2 + (y[:, None] - goal_y) ** 2 <= geometry.GOAL_RADIUS**2] = GOAL_COLOR
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


AGENT = (Field("x of the agent", "unit", 0.0, WIDTH), Field("y of the agent", "unit", 0.0, HEIGHT))
GOAL = (Field("x of the goal", "unit", 0.0, WIDTH), Field("y of the goal", "unit", 0.0, HEIGHT))
NEAREST = (
    # The border is solid, so the distance is at most half the inner height.
    Field("distance to the closest obstacle", "unit", 0.0, HEIGHT / 2 - CELL),
    Field("bearing to it, world frame, (−π, π]", "rad", -np.pi, np.pi),
)
RANGE = "range along beam i, at 22.5°·i in the world frame; 100 without a hit"
RANGES = (Field(RANGE, "unit", 0.0, MAX_RANGE, BEAMS),)

FIELDS: dict[str, tuple[Field, ...]] = {
    "state": AGENT + NEAREST,
    "state-goal": AGENT + NEAREST + GOAL,
    "range": RANGES,
    "range-known": RANGES + AGENT + GOAL,
}
"""The numbers that each family observes, in order; the family ``image`` is a picture."""


def observation_space(family: str) -> Box:
    """Returns the observation space of a family."""
    if family == "image":
        return Box(0, 255, (round(HEIGHT / PIXEL), round(WIDTH / PIXEL), 3), np.uint8)
    low = np.array([field.low for field in FIELDS[family] for _ in range(field.count)], np.float32)
    high = np.array([field.high for field in FIELDS[family] for _ in range(field.count)], np.float32)
    return Box(low, high, dtype=np.float32)


def action_space() -> Box:
    """Returns the action space, which is the displacement in x and in y in units per step."""
    return Box(-geometry.MAX_SPEED, geometry.MAX_SPEED, (2,), np.float32)
