"""``is_success``: its definition by body, its limits, and equal values in single and vector environments."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from gym_extensions.catalog.bodies import BODIES
from gym_extensions.catalog.bodies.success import Arrival, Distance, Height
from gym_extensions.envs import make, make_vec
from gym_extensions.envs.success import success_test

ARMS = ("Pusher", "Striker")
STANDING = ("HumanoidStandup", "HumanoidStandupAndRun")


def still(env: Any) -> Any:
    """An action of zeros."""
    return np.zeros(env.action_space.shape, np.float32)


def test_the_definitions_are_those_of_the_published_tasks() -> None:
    # A change here needs a new version of every task of the body.
    definitions = {
        name: (
            (*rule.bodies, rule.limit)
            if isinstance(rule, Distance)
            else (rule.low, rule.high)
            if isinstance(rule, Height)
            else type(rule)
        )
        for name, body in BODIES.items()
        if (rule := body.success)
    }
    assert definitions == {
        "Pusher": ("object", "goal", 0.05),
        "Striker": ("object", "goal", 0.05),
        "HumanoidStandup": (1.0, 2.0),
        "HumanoidStandupAndRun": (1.0, 2.0),
        "Navigation": Arrival,
    }


@pytest.mark.parametrize("name", ["Hopper", "Walker2d", "HalfCheetah", "Humanoid"])
def test_running_tasks_report_no_success(name: str) -> None:
    env: Any = make(name)
    env.reset(seed=0)
    assert "is_success" not in env.step(still(env))[4]


def arm_state(name: str, gap: float) -> tuple[Any, Any]:
    """An arm at rest whose object is ``gap`` m from the goal in x, and its saved state."""
    env: Any = make(name)
    env.reset(seed=0)
    state = env.unwrapped.save_state()
    state["qvel"][:] = 0
    if name == "Pusher":
        state["qpos"][-4:-2] = state["qpos"][-2:] + np.array((0.0, gap))
    else:
        state["qpos"][-2:] = state["mocap_pos"][0, 1::-1] + np.array((0.0, gap))
    return env, state


@pytest.mark.parametrize(("gap", "expected"), [(0.0, True), (0.0495, True), (0.0505, False), (-0.3, False)])
def test_pusher_succeeds_within_5_cm_on_the_table(gap: float, expected: bool) -> None:
    env, state = arm_state("Pusher", gap)
    env.unwrapped.restore_state(state)
    success = env.step(still(env))[4]["is_success"]
    assert success is expected


def test_striker_succeeds_with_the_ball_in_the_cup() -> None:
    outcomes = []
    for gap in (0.0, 0.3):
        env, state = arm_state("Striker", gap)
        env.unwrapped.restore_state(state)
        outcomes.append(env.step(still(env))[4]["is_success"])
    assert outcomes == [True, False]


@pytest.mark.parametrize("name", STANDING)
@pytest.mark.parametrize(("height", "expected"), [(0.9, False), (1.1, True), (1.9, True), (2.1, False)])
def test_a_humanoid_stands_between_1_and_2_m(name: str, height: float, expected: bool) -> None:
    env: Any = make(name)
    env.reset(seed=0)
    state = env.unwrapped.save_state()
    state["qpos"][2], state["qvel"][:] = height, 0
    env.unwrapped.restore_state(state)
    assert env.step(still(env))[4]["is_success"] is expected


def test_the_limits_of_a_height_are_outside() -> None:
    rule = Height(1.0, 2.0, "")
    test: Any = success_test(rule, None)
    assert test(np.array([[0, 0, 1.0], [0, 0, 1.5], [0, 0, 2.0], [0, 0, np.nan]])).tolist() == [0, 1, 0, 0]


def test_a_mujoco_body_cannot_define_an_arrival() -> None:
    with pytest.raises(ValueError, match="Define a distance or a height"):
        success_test(Arrival(""), None)


def test_navigation_succeeds_where_it_terminates() -> None:
    env: Any = make("State-Based-Navigation-2d-Map0-Goal0")
    goal = env.unwrapped.arena.goal
    env.reset(options={"start": (goal[0] + 21.0, goal[1])})
    terminated, _, info = env.step(np.array([5.0, 0.0], np.float32))[2:]
    assert (terminated, info) == (False, {"is_success": False})
    steps = [env.step(np.array([-5.0, 0.0], np.float32)) for _ in range(2)]
    assert [(step[2], step[4]["is_success"]) for step in steps] == [(False, False), (True, True)]


@pytest.mark.parametrize("name", [*ARMS, *STANDING])
def test_a_vector_environment_has_the_success_of_the_single_one(name: str) -> None:
    batch: Any = make_vec(name, 2)
    batch.reset(seed=[0, 1])
    states = batch.save_states()
    if name in ARMS:
        states["qpos"][0] = arm_state(name, 0.01)[1]["qpos"]
        if name == "Striker":
            states["mocap_pos"][0] = arm_state(name, 0.01)[1]["mocap_pos"]
    else:
        states["qpos"][0, 2] = 1.3
    batch.restore_states(states)
    infos = batch.step(np.zeros(batch.action_space.shape, np.float32))[4]
    assert infos["is_success"].tolist() == [True, False]
    assert infos["_is_success"].tolist() == [True, True]


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
