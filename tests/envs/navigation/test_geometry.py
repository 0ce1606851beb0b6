"""Points and segments on closed cells: by hand, and compared with exact fractions."""

from fractions import Fraction

import numpy as np
import pytest

from gym_extensions.envs.navigation import geometry
from gym_extensions.envs.navigation.env import World


def test_the_first_line_of_a_map_is_its_top() -> None:
    grid = geometry.parse(["####", "#.##", "#..#", "####"])
    assert grid.cells[1].tolist() == [True, False, False, True]
    assert grid.cells[2].tolist() == [True, False, True, True]


# Free inside: x and y from 10 to 60, but for the block x 30–40, y 30–40.
BLOCK = geometry.parse(["#######", "#.....#", "#.....#", "#..#..#", "#.....#", "#.....#", "#######"])
# Two blocks that meet at the corner (30, 30).
DIAGONAL = geometry.parse(["######", "#....#", "#..#.#", "#.#..#", "#....#", "######"])


@pytest.mark.parametrize(
    ("point", "inside"),
    [
        ((35.0, 35.0), True),
        ((30.0, 35.0), True),  # on an edge
        ((40.0, 40.0), True),  # on a corner
        ((np.nextafter(30.0, 0), 35.0), False),
        ((np.nextafter(40.0, 99), 40.0), False),
        ((20.0, 20.0), False),  # on a corner of four free cells
        ((10.0, 25.0), True),  # on the border's edge
        ((-3.0, 25.0), True),  # outside all is solid
        ((float("nan"), 25.0), True),
    ],
)
def test_a_point_is_in_an_obstacle_with_edges_and_corners(point: tuple[float, float], inside: bool) -> None:
    assert geometry.touches(BLOCK.solid, *point) is inside


@pytest.mark.parametrize(
    ("start", "end", "collides"),
    [
        ((28.0, 35.0), (33.0, 35.0), True),  # into the block
        ((25.0, 35.0), (30.0, 35.0), True),  # up to its edge
        ((29.0, 30.0), (32.0, 30.0), True),  # along its lower edge
        ((29.0, 29.5), (34.0, 29.5), False),  # just below it
        ((28.0, 32.0), (32.0, 28.0), True),  # across its corner (30, 30): touched at one point
        ((29.0, 30.5), (30.5, 29.0), False),
        ((25.0, 25.0), (25.0, 25.0), False),  # no motion
        ((12.0, 12.0), (9.0, 12.0), True),  # into the border
    ],
)
def test_a_segment_that_touches_an_obstacle_collides(
    start: tuple[float, float], end: tuple[float, float], collides: bool
) -> None:
    assert geometry.crosses(BLOCK.solid, *start, *end) is collides
    assert (geometry.touches(BLOCK.solid, *end) or geometry.crosses(BLOCK.solid, *end, *start)) is collides


def test_a_diagonal_gap_is_closed() -> None:
    # From the upper left of (30, 30) to its lower right, through the corner where the blocks meet.
    assert geometry.crosses(DIAGONAL.solid, 28.0, 32.0, 32.0, 28.0)
    assert geometry.crosses(DIAGONAL.solid, 29.99, 30.01, 30.01, 29.99)


def exactly_crosses(grid: geometry.Grid, start: np.ndarray, end: np.ndarray) -> bool:
    """Whether the closed segment meets any closed cell, in fractions, by clipping it against each box."""
    origin = [Fraction(float(value)) for value in start]
    along = [Fraction(float(to)) - before for to, before in zip(end, origin, strict=True)]
    for row, column in np.argwhere(grid.cells):
        enter, leave = Fraction(0), Fraction(1)
        for low, at, move in zip((10 * int(column), 10 * int(row)), origin, along, strict=True):
            if move == 0:
                if not low <= at <= low + 10:
                    leave = Fraction(-1)
                continue
            sides = sorted(((low - at) / move, (low + 10 - at) / move))
            enter, leave = max(enter, sides[0]), min(leave, sides[1])
        if enter <= leave:
            return True
    return False


def test_motion_agrees_with_exact_fractions_on_random_moves() -> None:
    generator, grid = np.random.default_rng(5), geometry.load(8)
    window = geometry.Grid(np.pad(grid.solid[10:24, 10:24], 1, constant_values=1))
    # Whole numbers meet edges and corners exactly.
    starts = np.vstack([generator.uniform(10, 130, (700, 2)), generator.integers(10, 130, (700, 2))])
    collisions = 0
    for start in starts:
        if geometry.touches(window.solid, *start):
            continue
        end = start + generator.integers(-10, 11, 2) / 2
        collided = geometry.crosses(window.solid, *start, *end)
        assert collided == exactly_crosses(window, start, end), (start, end)
        collisions += collided
    assert collisions > 40


def step(
    arena: geometry.Arena, start: tuple[float, float], action: tuple[float, float]
) -> tuple[list[float], float, bool]:
    world = World([arena], "state")
    world.positions[0] = start
    rewards, reached = world.advance(np.array([action], dtype=np.float32), np.zeros(1, dtype=bool))
    return world.positions[0].tolist(), float(rewards[0]), bool(reached[0])


FAR = geometry.Arena(BLOCK, (1000.0, 1000.0))


@pytest.mark.parametrize(
    ("start", "action", "position"),
    [
        ((15.0, 15.0), (3.0, -2.5), [18.0, 12.5]),
        ((15.0, 15.0), (50.0, 2.0), [20.0, 17.0]),  # clipped to 5
        ((15.0, 15.0), (1.0, -7.0), [15.0, 15.0]),  # clipped to -5, and so on to the border: stays
        ((28.0, 35.0), (5.0, 0.0), [28.0, 35.0]),  # a collision stops the whole motion
        ((28.0, 35.0), (1.5, 1.0), [29.5, 36.0]),
    ],
)
def test_a_step_moves_by_the_clipped_action_or_not_at_all(
    start: tuple[float, float], action: tuple[float, float], position: list[float]
) -> None:
    assert step(FAR, start, action)[0] == position


@pytest.mark.parametrize(
    ("goal", "start", "action", "reward", "reached"),
    [
        ((1000.0, 1000.0), (15.0, 15.0), (1.0, 1.0), -1.0, False),
        ((1000.0, 1000.0), (28.0, 35.0), (5.0, 0.0), -6.0, False),  # a collision
        ((45.0, 15.0), (24.0, 15.0), (1.0, 0.0), 9.0, True),  # to a distance of exactly 20
        ((45.0, 15.0), (23.0, 15.0), (1.0, 0.0), -1.0, False),  # to 21
        ((27.0, 38.0), (25.0, 15.0), (5.0, 0.0), -1.0, False),  # distance counts only at the new position
        ((28.0, 35.0), (28.0, 35.0), (5.0, 0.0), 4.0, True),  # a collision within the goal
        ((22.5, 35.0), (20.0, 15.0), (2.5, 0.0), 9.0, True),  # to a distance of exactly 20
        ((22.5, 35.0), (20.0, 15.0), (5.0, 0.0), -1.0, False),  # through that place, to a farther one
    ],
)
def test_the_reward_is_minus_one_minus_five_for_a_collision_plus_ten_at_the_goal(
    goal: tuple[float, float],
    start: tuple[float, float],
    action: tuple[float, float],
    reward: float,
    reached: bool,
) -> None:
    assert step(geometry.Arena(BLOCK, goal), start, action)[1:] == (reward, reached)
