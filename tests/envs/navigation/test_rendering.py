"""Rendering: frames as arrays, and the render modes that do not exist."""

import numpy as np
import pytest

from gym_extensions.catalog.groups import group
from gym_extensions.catalog.tasks import FAMILIES, task
from gym_extensions.envs import make
from gym_extensions.envs.navigation.env import Navigation

from ...conftest import refused

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


@pytest.mark.parametrize(("mode", "hint"), [("human", "HumanRendering"), ("ansi", "rgb_array")])
def test_another_render_mode_raises_an_error_that_says_what_to_use(mode: str, hint: str) -> None:
    with refused("unknown-render-mode", hint):
        make(NAME, render_mode=mode)


def test_rendering_without_a_mode_warns_and_returns_none() -> None:
    env = Navigation(task(NAME))
    env.reset(seed=0)
    with pytest.warns(UserWarning, match="nothing to render"):
        assert env.render() is None
