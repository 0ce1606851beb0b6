"""Navigation: where episodes start, and what is rendered."""

import gymnasium as gym
import numpy as np
import pytest
from numpy.typing import NDArray

from gym_extensions.catalog.groups import group
from gym_extensions.catalog.tasks import FAMILIES, task
from gym_extensions.envs import make
from gym_extensions.envs.navigation.env import Navigation
from gym_extensions.envs.navigation.geometry import touches

from ...conftest import refused

TASK = "State-Based-Navigation-2d-Map2-Goal1"
RESETS = 2000


def starts() -> NDArray[np.float64]:
    env = Navigation(task(TASK))
    env.reset(seed=11)
    drawn = [env.position]
    for _ in range(RESETS - 1):
        env.reset()
        drawn.append(env.position)
    return np.array(drawn)


def test_starts_are_free_at_least_100_from_the_goal_and_uniform() -> None:
    arena, points = Navigation(task(TASK)).arena, starts()
    goal_x, goal_y = arena.goal
    assert np.hypot(points[:, 0] - goal_x, points[:, 1] - goal_y).min() >= 100
    assert not any(touches(arena.grid.solid, x, y) for x, y in points)
    # The share of starts in each of 8 x 6 blocks of 80 units is the block's share of the space to start from,
    # which is measured here with a fine lattice of its own. Chi-square, 47 degrees of freedom: 99.9 % lie
    # below 82.7.
    lattice = np.array([(x, y) for x in np.arange(0.5, 640) for y in np.arange(0.5, 480)])
    cells = arena.grid.cells[(lattice[:, 1] // 10).astype(int), (lattice[:, 0] // 10).astype(int)]
    allowed = lattice[~cells & (np.hypot(lattice[:, 0] - goal_x, lattice[:, 1] - goal_y) >= 100)]
    edges = [np.arange(0.0, 641.0, 80.0), np.arange(0.0, 481.0, 80.0)]
    share = np.histogram2d(allowed[:, 0], allowed[:, 1], bins=edges)[0].ravel() / len(allowed)
    counts = np.histogram2d(points[:, 0], points[:, 1], bins=edges)[0].ravel()
    assert counts[share == 0].sum() == 0
    possible = share > 0
    expected = share[possible] * RESETS
    assert ((counts[possible] - expected) ** 2 / expected).sum() < 82.7
    # Within the cells too: the places relative to the cell are uniform (9 degrees of freedom, 99.9 %: 27.9).
    for axis in (0, 1):
        places = np.histogram(points[:, axis] % 10, bins=10, range=(0, 10))[0]
        assert ((places - RESETS / 10) ** 2 / (RESETS / 10)).sum() < 27.9


NAME = "Limited-Range-Based-Navigation-2d-Map1-Goal0"


@pytest.mark.parametrize("family", FAMILIES)
def test_a_frame_shows_the_world_at_one_pixel_per_unit(family: str) -> None:
    env = Navigation(group(f"nav-{family}").tasks[7], render_mode="rgb_array")
    env.reset(seed=0)
    frame = env.render()
    assert frame is not None
    assert frame.shape == (480, 640, 3)
    assert frame.dtype == np.uint8
    x, y = env.position
    assert frame[480 - round(y), round(x)].tolist() == [0, 0, 0]
    assert frame[0, 0].tolist() == [204, 153, 102]
    goal_x, goal_y = env.arena.goal
    assert frame[480 - round(goal_y), round(goal_x)].tolist() == [255, 0, 0]


@pytest.mark.parametrize("max_steps", [None, 20])
def test_gymnasiums_window_shows_the_frames(max_steps: int | None) -> None:
    made = make(NAME, render_mode="human", max_steps=max_steps)
    assert made.spec is not None
    for env in (made, gym.make(made.spec)):
        assert (env.render_mode, env.unwrapped.render_mode) == ("human", "rgb_array")


def test_another_render_mode_raises_an_error_that_says_what_to_use() -> None:
    with refused("unknown-render-mode", "rgb_array"):
        make(NAME, render_mode="ansi")


def test_rendering_without_a_mode_warns_and_returns_none() -> None:
    env = Navigation(task(NAME))
    env.reset(seed=0)
    with pytest.warns(UserWarning, match="nothing to render"):
        assert env.render() is None
