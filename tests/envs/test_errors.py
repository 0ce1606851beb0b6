"""Invalid actions, states, variations and names, and their error messages."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from gym_extensions.envs import Gravity, MovingGoal, Task, make
from gym_extensions.envs.make import construct_mujoco
from gym_extensions.errors import BenchError

WHERE = "gym_extensions/HopperGravityHalf-v0"


@pytest.mark.parametrize(
    ("action", "text"),
    [
        (np.zeros(4), "The action has shape (4,); expected (3,). Give one number per actuator."),
        (np.zeros((1, 3)), "The action has shape (1, 3); expected (3,). Give one number per actuator."),
        (0.5, "The action has shape (); expected (3,). Give one number per actuator."),
        (np.array([0, np.nan, 0]), "action[1] is nan. Give finite numbers."),
        (np.array([0, 0, -np.inf]), "action[2] is -inf. Give finite numbers."),
        (["a", "b", "c"], "The action has dtype <U1. Give floating-point numbers."),
        ([True, False, True], "The action has dtype bool. Give floating-point numbers."),
    ],
)
def test_an_invalid_action_raises_an_error(action: object, text: str) -> None:
    env = make("HopperGravityHalf")
    env.reset(seed=0)
    with pytest.raises(BenchError) as caught:
        env.step(action)
    assert str(caught.value) == f"{WHERE}: {text}"


def test_an_action_out_of_range_is_applied_as_by_gymnasiums_body() -> None:
    env = make("HopperGravityHalf")
    env.reset(seed=0)
    assert env.step(np.full(3, 9.0, np.float32))[4]["reward_ctrl"] == pytest.approx(-1e-3 * 3 * 81)


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"qpos": None}, "The state has no entry 'qpos'."),
        ({"speed": np.zeros(1)}, "The state has an unknown entry 'speed'."),
        ({"qvel": np.zeros(5)}, "The state's 'qvel' has shape (5,); expected (6,)."),
        ({"qvel": np.full(6, np.nan)}, "The state's 'qvel' has a value that is not finite."),
    ],
)
def test_an_invalid_state_raises_an_error(change: dict[str, Any], text: str) -> None:
    env = construct_mujoco("HopperGravityHalf")
    env.reset(seed=0)
    state = {name: value for name, value in (env.save_state() | change).items() if value is not None}
    with pytest.raises(BenchError) as caught:
        env.restore_state(state)
    assert str(caught.value) == f"{WHERE}: {text}"


@pytest.mark.parametrize("steps", [0, -3, 2.5, True, "10"])
def test_a_time_limit_below_1_raises_an_error(steps: Any) -> None:
    with pytest.raises(BenchError) as caught:
        make("Hopper", max_steps=steps)
    assert str(caught.value) == f"max_steps is {steps!r}. Give a whole number above 0."


@pytest.mark.parametrize(
    ("task", "variations", "text"),
    [
        ("Hopper", Gravity(0.5), "variations is Gravity(factor=0.5). Give a list, even for one variation."),
        ("Hopper", ["Gravity"], "'Gravity' is not a variation. Give values such as Gravity(0.8)."),
        (
            "Pusher",
            [Gravity(0.5)],
            "gym_extensions/Pusher.Gravity-0.5-v0: Gravity does not fit Pusher. "
            "It fits Hopper, Walker2d, HalfCheetah, Humanoid, HumanoidStandup, "
            "HumanoidStandupAndRun.",
        ),
        (
            "Hopper",
            [MovingGoal()],
            "gym_extensions/Hopper.MovingGoal-v0: MovingGoal does not fit Hopper. It fits Pusher.",
        ),
        (
            Task("Mine", "Hoper"),
            [],
            "gym_extensions/Mine-v0: There is no base body 'Hoper'. Did you mean 'Hopper'?",
        ),
    ],
)
def test_a_variation_or_base_that_does_not_fit_raises_an_error(task: Any, variations: Any, text: str) -> None:
    with pytest.raises(BenchError) as caught:
        make(task, variations)
    assert str(caught.value) == text


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("HopperGravtyHalf", "There is no task 'HopperGravtyHalf'. Did you mean 'HopperGravityHalf'?"),
        (
            "gym_extensions/hopper-v0",
            "There is no task 'gym_extensions/hopper-v0'. Did you mean 'gym_extensions/Hopper-v0'?",
        ),
    ],
)
def test_an_unknown_task_raises_an_error_with_the_closest_name(name: str, text: str) -> None:
    with pytest.raises(BenchError) as caught:
        make(name)
    assert str(caught.value) == text
