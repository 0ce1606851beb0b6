"""Rendering: frames as arrays, and the render modes that do not exist."""

from __future__ import annotations

import numpy as np
import pytest

from gym_extensions.catalog.groups import group
from gym_extensions.catalog.navigation_tasks import FAMILIES
from gym_extensions.catalog.registry import task
from gym_extensions.envs import make
from gym_extensions.envs.navigation.build import construct
from gym_extensions.errors import BenchError

NAME = "Limited-Range-Based-Navigation-2d-Map1-Goal0"


@pytest.mark.parametrize("family", FAMILIES)
def test_a_frame_shows_the_world_at_one_pixel_per_unit(family: str) -> None:
    env = construct(group(f"nav-{family}").tasks[7], render_mode="rgb_array")
    env.reset(seed=0)
    frame = env.render()
    assert frame is not None
    assert frame.shape == (480, 640, 3)
    assert frame.dtype == np.uint8
    x, y = env.save_state()["position"]
    assert frame[480 - round(y), round(x)].tolist() == [0, 0, 0]
    assert frame[0, 0].tolist() == [204, 153, 102]
    goal_x, goal_y = env.arena.goal
    assert frame[480 - round(goal_y), round(goal_x)].tolist() == [255, 0, 0]


def test_frames_follow_the_agent() -> None:
    env = make(NAME, render_mode="rgb_array")
    env.reset(seed=3)
    frames = [env.render()]
    for action in np.full((3, 2), 2.0, np.float32):
        env.step(action)
        frames.append(env.render())
    assert len({np.asarray(frame).tobytes() for frame in frames}) == 4


@pytest.mark.parametrize(
    ("mode", "hint"),
    [
        (
            "human",
            'For a window: gymnasium.wrappers.HumanRendering(make(..., render_mode="rgb_array")).',
        ),
        ("ansi", 'Use render_mode="rgb_array".'),
    ],
)
def test_another_render_mode_raises_an_error_that_says_what_to_use(mode: str, hint: str) -> None:
    with pytest.raises(BenchError) as caught:
        make(NAME, render_mode=mode)
    assert caught.value.code == "unknown-render-mode"
    assert str(caught.value) == f"{task(NAME).id}: Navigation has no render mode {mode!r}. {hint}"


def test_rendering_without_a_mode_warns_and_returns_none() -> None:
    env = construct(task(NAME))
    env.reset(seed=0)
    with pytest.warns(UserWarning, match="nothing to render"):
        assert env.render() is None
