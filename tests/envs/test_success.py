"""``is_success``: its definition by body, its limits, and equal values in single and vector environments."""

from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np
import pytest

from gym_extensions.envs import make, make_vec


def still(env: Any) -> Any:
    """An action of zeros."""
    return np.zeros(env.action_space.shape, np.float32)


@pytest.mark.parametrize("name", ["Hopper", "Walker2d", "HalfCheetah", "Humanoid"])
def test_running_tasks_report_no_success(name: str) -> None:
    env: Any = make(name)
    env.reset(seed=0)
    assert "is_success" not in env.step(still(env))[4]


def success_of(name: str, change: Callable[[Any], None]) -> bool:
    """Whether a body at rest is a success one step after a change of its positions."""
    env: Any = make(name)
    env.reset(seed=0)
    data = env.unwrapped.data
    data.qvel[:] = 0
    change(data)
    mujoco.mj_forward(env.unwrapped.model, data)
    success: bool = env.step(still(env))[4]["is_success"]
    return success


@pytest.mark.parametrize(("gap", "expected"), [(0.0, True), (0.0495, True), (0.0505, False), (-0.3, False)])
def test_pusher_succeeds_within_5_cm_on_the_table(gap: float, expected: bool) -> None:
    def place(data: Any) -> None:
        data.qpos[-4:-2] = data.qpos[-2:] + np.array((0.0, gap))

    assert success_of("Pusher", place) is expected


@pytest.mark.parametrize(("gap", "expected"), [(0.0, True), (0.3, False)])
def test_striker_succeeds_with_the_ball_in_the_cup(gap: float, expected: bool) -> None:
    def place(data: Any) -> None:
        data.qpos[-2:] = data.mocap_pos[0, 1::-1] + np.array((0.0, gap))

    assert success_of("Striker", place) is expected


@pytest.mark.parametrize("name", ["HumanoidStandup", "HumanoidStandupAndRun"])
@pytest.mark.parametrize(("height", "expected"), [(0.9, False), (1.1, True), (1.9, True), (2.1, False)])
def test_a_humanoid_stands_between_1_and_2_m(name: str, height: float, expected: bool) -> None:
    def place(data: Any) -> None:
        data.qpos[2] = height

    assert success_of(name, place) is expected


def test_navigation_succeeds_where_it_terminates() -> None:
    env: Any = make("State-Based-Navigation-2d-Map0-Goal0")
    goal = env.unwrapped.arena.goal
    env.reset(seed=0)
    env.unwrapped._world.positions[0] = goal[0] + 21.0, goal[1]
    terminated, _, info = env.step(np.array([5.0, 0.0], np.float32))[2:]
    assert (terminated, info) == (False, {"is_success": False})
    steps = [env.step(np.array([-5.0, 0.0], np.float32)) for _ in range(2)]
    assert [(step[2], step[4]["is_success"]) for step in steps] == [(False, False), (True, True)]


def test_environments_of_other_tasks_and_after_an_end_do_not_report() -> None:
    batch: Any = make_vec(["Humanoid", "HumanoidStandup"], 2)
    batch.reset(seed=[0, 1])
    infos = batch.step(np.zeros(batch.action_space.shape, np.float32))[4]
    assert infos["is_success"].tolist() == [False, False]
    assert infos["_is_success"].tolist() == [False, True]
    arm: Any = make_vec("Pusher", 1)
    arm.reset(seed=0)
    reports = [arm.step(np.zeros((1, 7), np.float32))[4] for _ in range(101)]
    assert ["is_success" in infos for infos in reports] == [True] * 100 + [False]
