"""``is_success``: its definition by body, and its limits."""

from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np
import pytest

from gym_extensions.envs import make


@pytest.mark.parametrize("name", ["Hopper", "Walker2d", "HalfCheetah", "Humanoid"])
def test_running_tasks_report_no_success(name: str) -> None:
    env: Any = make(name)
    env.reset(seed=0)
    assert "is_success" not in env.step(np.zeros(env.action_space.shape, np.float32))[4]


def object_from_goal(data: Any, gap: float) -> None:
    data.qpos[-4:-2] = data.qpos[-2:] + np.array((0.0, gap))


def ball_from_cup(data: Any, gap: float) -> None:
    data.qpos[-2:] = data.mocap_pos[0, 1::-1] + np.array((0.0, gap))


def torso(data: Any, height: float) -> None:
    data.qpos[2] = height


@pytest.mark.parametrize(
    ("name", "place", "metres", "expected"),
    [
        *(("Pusher", object_from_goal, gap, abs(gap) < 0.05) for gap in (0.0, 0.0495, 0.0505, -0.3)),
        *(("Striker", ball_from_cup, gap, gap == 0) for gap in (0.0, 0.3)),
        *(("HumanoidStandup", torso, height, 1 < height < 2) for height in (0.9, 1.1, 1.9, 2.1)),
        *(("HumanoidStandupAndRun", torso, height, 1 < height < 2) for height in (0.9, 1.1, 1.9, 2.1)),
    ],
)
def test_a_body_at_rest_succeeds_near_its_goal(
    name: str, place: Callable[[Any, float], None], metres: float, expected: bool
) -> None:
    env: Any = make(name)
    env.reset(seed=0)
    data = env.unwrapped.data
    data.qvel[:] = 0
    place(data, metres)
    mujoco.mj_forward(env.unwrapped.model, data)
    assert env.step(np.zeros(env.action_space.shape, np.float32))[4]["is_success"] is expected


def test_navigation_succeeds_where_it_terminates() -> None:
    env: Any = make("State-Based-Navigation-2d-Map0-Goal0")
    goal = env.unwrapped.arena.goal
    env.reset(seed=0)
    env.unwrapped._world.positions[0] = goal[0] + 21.0, goal[1]
    terminated, _, info = env.step(np.array([5.0, 0.0], np.float32))[2:]
    assert (terminated, info) == (False, {"is_success": False})
    steps = [env.step(np.array([-5.0, 0.0], np.float32)) for _ in range(2)]
    assert [(step[2], step[4]["is_success"]) for step in steps] == [(False, False), (True, True)]
