"""Navigation observations: by hand on small maps, and by independent calculation at random poses."""

import math
from typing import Any

import numpy as np
import pytest

from gym_extensions.catalog.groups import group
from gym_extensions.catalog.tasks import FAMILIES
from gym_extensions.envs import make_vec
from gym_extensions.envs.navigation import geometry
from gym_extensions.envs.navigation.env import World

OPEN = ["#" + "." * 28 + "#"] * 28
ROOM = geometry.parse(["#" * 30, *OPEN, "#" * 30])
"""Free from 10 to 290 in both directions."""
NOWHERE = (-1000.0, -1000.0)


def blocks(*cells: tuple[int, int]) -> geometry.Grid:
    """The room with some cells, (column, row) from the lower left, solid."""
    solid = ROOM.solid.copy()
    for column, row in cells:
        solid[row + 1, column + 1] = 1
    return geometry.Grid(solid)


def observed(
    grid: geometry.Grid, point: tuple[float, float], family: str, goal: tuple[float, float] = NOWHERE
) -> Any:
    world = World([geometry.Arena(grid, goal)], family)
    world.positions[0] = point
    return world.observe()[0]


@pytest.mark.parametrize(
    ("cells", "point", "beam", "reading"),
    [
        ([(18, 15)], (155.0, 155.0), 0, 25.0),  # east, head on
        ([(12, 15)], (155.0, 155.0), 8, 25.0),  # west
        ([(18, 15)], (155.0, 160.0), 0, 25.0),  # along the block's upper edge: hits
        ([(18, 15)], (155.0, 150.0), 0, 25.0),  # along its lower edge
        ([(18, 15)], (155.0, np.nextafter(160.0, 999)), 0, 100.0),  # just above it
        ([(15, 18)], (160.0, 155.0), 4, 25.0),  # along a vertical edge
        ([(17, 17)], (155.0, 155.0), 2, 15 * math.sqrt(2)),  # into a corner, into the block
        ([(16, 17)], (155.0, 155.0), 2, 15 * math.sqrt(2)),  # touches its corner (170, 170) and passes
        ([(16, 17), (17, 16)], (155.0, 155.0), 2, 15 * math.sqrt(2)),  # a diagonal gap is closed
        ([(13, 14)], (155.0, 155.0), 10, 15 * math.sqrt(2)),  # its corner (140, 140), to the lower left
        ([(26, 15)], (160.0, 155.0), 0, 100.0),  # at 100 exactly
        ([(26, 15)], (155.0, 155.0), 0, 100.0),  # out of range
    ],
)
def test_a_ray_hits_closed_cells(
    cells: list[tuple[int, int]], point: tuple[float, float], beam: int, reading: float
) -> None:
    assert observed(blocks(*cells), point, "range")[beam] == pytest.approx(reading, abs=1e-5)


def boxes(grid: geometry.Grid) -> np.ndarray:
    rows, columns = np.nonzero(grid.solid)
    low = np.column_stack([columns - 1, rows - 1]) * 10.0
    return np.stack([low, low + 10.0], axis=1)


def slab_range(low: Any, high: Any, point: Any, angle: float) -> float:
    """The range by the slab test against every obstacle at once; no grid is walked."""
    with np.errstate(divide="ignore"):
        per = 1.0 / np.array([math.cos(angle), math.sin(angle)])
    near, far = (low - point) * per, (high - point) * per
    enter, leave = np.minimum(near, far).max(axis=1), np.maximum(near, far).min(axis=1)
    return float(min(100.0, enter[(enter <= leave) & (leave >= 0)].min(initial=100.0)))


def poses(count: int, seed: int) -> list[tuple[int, np.ndarray]]:
    generator = np.random.default_rng(seed)
    drawn = []
    for index in range(count):
        world = World([geometry.arena(index % 10, index % 3)], "state")
        world.draw_start(0, generator)
        drawn.append((index % 10, world.positions[0].copy()))
    return drawn


def test_ranges_agree_with_the_slab_test_at_100_random_poses() -> None:
    hits = 0
    for number, point in poses(100, seed=1):
        low, high = boxes(geometry.load(number)).transpose(1, 0, 2)
        expected = [slab_range(low, high, point, math.radians(22.5 * beam)) for beam in range(16)]
        readings = observed(geometry.load(number), tuple(point), "range")
        np.testing.assert_allclose(readings, expected, atol=1e-5, rtol=0)
        hits += int((readings < 100).sum())
    assert 400 < hits < 1600


def test_the_closest_obstacle_agrees_with_all_obstacles_at_100_random_poses() -> None:
    for number, point in poses(100, seed=2):
        low, high = boxes(geometry.load(number)).transpose(1, 0, 2)
        gaps = np.clip(point, low, high) - point
        distances = np.hypot(*gaps.T)
        x, y, distance, bearing = observed(geometry.load(number), tuple(point), "state")
        assert [x, y] == point.astype(np.float32).tolist()
        assert distance == pytest.approx(distances.min(), abs=1e-5)
        bearings = np.arctan2(gaps[:, 1], gaps[:, 0])[distances <= distances.min() + 1e-9]
        assert bearing == pytest.approx(bearings.min(), abs=1e-5)


@pytest.mark.parametrize(
    ("cells", "point", "distance", "bearing"),
    [
        ([(18, 15)], (155.0, 155.0), 25.0, 0.0),
        ([(15, 18)], (155.0, 155.0), 25.0, math.pi / 2),
        ([(12, 15)], (155.0, 155.0), 25.0, math.pi),  # the interval is (-pi, pi]
        ([(15, 12)], (155.0, 155.0), 25.0, -math.pi / 2),
        ([(17, 17)], (155.0, 155.0), 15 * math.sqrt(2), math.pi / 4),  # a corner
        ([(18, 15), (15, 12)], (155.0, 155.0), 25.0, -math.pi / 2),  # of equally close ones the least bearing
        ([], (150.0, 30.0), 20.0, -math.pi / 2),  # the border
    ],
)
def test_distance_and_bearing_are_those_of_the_closest_edge(
    cells: list[tuple[int, int]], point: tuple[float, float], distance: float, bearing: float
) -> None:
    observation = observed(blocks(*cells), point, "state")
    assert observation.tolist() == pytest.approx([*point, distance, bearing], abs=1e-5)


def test_the_families_that_know_positions_append_them() -> None:
    point, goal = (155.0, 105.0), (45.0, 65.0)
    state, ranges = observed(ROOM, point, "state"), observed(ROOM, point, "range")
    assert observed(ROOM, point, "state-goal", goal).tolist() == [*state, 45.0, 65.0]
    assert observed(ROOM, point, "range-known", goal).tolist() == [*ranges, 155.0, 105.0, 45.0, 65.0]


def test_a_picture_shows_what_lies_at_each_pixels_centre() -> None:
    place = geometry.arena(0, 0)
    picture = World([place], "image")
    picture.positions[0] = (300.3, 101.7)
    shown = picture.observe()[0]
    assert (shown.shape, shown.dtype) == ((120, 160, 3), np.uint8)
    low, high = boxes(place.grid).transpose(1, 0, 2)
    for row in range(120):
        y = 480 - (4 * row + 2)
        for column in range(160):
            x = 4 * column + 2
            if math.hypot(x - 300.3, y - 101.7) <= 5:
                colour = (0, 0, 0)
            elif math.hypot(x - place.goal[0], y - place.goal[1]) <= 20:
                colour = (255, 0, 0)
            elif ((low <= (x, y)) & ((x, y) <= high)).all(axis=1).any():
                colour = (204, 153, 102)
            else:
                colour = (255, 255, 255)
            assert tuple(shown[row, column]) == colour, (x, y)


def test_the_agents_disc_leaves_no_trace_and_is_drawn_over_the_goal() -> None:
    place = geometry.arena(3, 1)
    x, y = place.goal
    moved, fresh = World([place], "image"), World([place], "image")
    for point in ((x + 30, y), (x + 18, y), (x + 1, y + 1)):
        moved.positions[0] = point
        shown = moved.observe()[0]
    fresh.positions[0] = (x + 1, y + 1)
    np.testing.assert_array_equal(shown, fresh.observe()[0])
    row, column = int((480 - y - 1) // 4), int((x + 1) // 4)
    assert shown[row, column].tolist() == [0, 0, 0]
    assert (shown == (255, 0, 0)).all(axis=2).sum() > 50


@pytest.mark.parametrize("family", FAMILIES)
def test_observations_of_30000_random_steps_are_in_the_space(family: str) -> None:
    batch: Any = make_vec(group(f"nav-{family}").tasks, 60)
    space, rewards = batch.single_observation_space, set()
    observations, _ = batch.reset(seed=0)
    # Runs of one action press against walls and corners, which single random steps hardly do.
    for action in np.random.default_rng(3).uniform(-5, 5, (50, 60, 2)).astype(np.float32):
        for _ in range(10):
            assert observations.dtype == space.dtype
            assert (observations >= space.low).all()
            assert (observations <= space.high).all()
            observations, reward, *_ = batch.step(action)
            rewards |= set(reward.tolist())
    assert {-1.0, -6.0} < rewards <= {-1.0, -6.0, 9.0, 0.0}
