"""Bad actions and bad states, and the exact words that refuse them."""

from __future__ import annotations

import numpy as np
import pytest

from gym_extensions.envs import Gravity, MovingGoal, Task, group, make
from gym_extensions.errors import BenchError

WHERE = "gym_extensions/HopperGravityHalf-v0"


@pytest.mark.parametrize(
    ("action", "text"),
    [
        (np.zeros(4), "The action has shape (4,), not (3,). Give one number per actuator."),
        (np.zeros((1, 3)), "The action has shape (1, 3), not (3,). Give one number per actuator."),
        (0.5, "The action has shape (), not (3,). Give one number per actuator."),
        (np.array([0, np.nan, 0]), "action[1] is nan. Give finite numbers."),
        (np.array([0, 0, -np.inf]), "action[2] is -inf. Give finite numbers."),
        (["a", "b", "c"], "The action holds <U1 values. Give floating-point numbers."),
        ([True, False, True], "The action holds bool values. Give floating-point numbers."),
    ],
)
def test_a_bad_action_is_refused(action: object, text: str) -> None:
    env = make("HopperGravityHalf")
    env.reset(seed=0)
    with pytest.raises(BenchError) as caught:
        env.step(action)
    assert str(caught.value) == f"{WHERE}: {text}"


def test_an_action_out_of_range_is_left_to_gymnasiums_body() -> None:
    env = make("HopperGravityHalf")
    env.reset(seed=0)
    assert env.step(np.full(3, 9.0, np.float32))[4]["reward_ctrl"] == pytest.approx(-1e-3 * 3 * 81)


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"qpos": None}, "The state lacks 'qpos'."),
        ({"speed": np.zeros(1)}, "The state holds an unknown 'speed'."),
        ({"qvel": np.zeros(5)}, "The state's 'qvel' has shape (5,), not (6,)."),
        ({"qvel": np.full(6, np.nan)}, "The state's 'qvel' holds a value that is not finite."),
    ],
)
def test_a_bad_state_is_refused(change: dict, text: str) -> None:
    env = make("HopperGravityHalf").unwrapped
    env.reset(seed=0)
    given = {name: value for name, value in (env.save_state() | change).items() if value is not None}
    with pytest.raises(BenchError) as caught:
        env.restore_state(given)
    assert str(caught.value) == f"{WHERE}: {text}"


@pytest.mark.parametrize("steps", [0, -3, 2.5, True, "10"])
def test_a_time_limit_below_one_is_refused(steps: object) -> None:
    with pytest.raises(BenchError) as caught:
        make("Hopper", max_steps=steps)
    assert str(caught.value) == f"max_steps is {steps!r}. Give a whole number above 0."


@pytest.mark.parametrize(
    ("task", "variations", "text"),
    [
        ("Hopper", Gravity(0.5), "variations is Gravity(factor=0.5). Give a list, even of one variation."),
        ("Hopper", ["Gravity"], "'Gravity' is no variation. Give values such as Gravity(0.8)."),
        (
            "Pusher",
            [Gravity(0.5)],
            "Gravity does not fit Pusher. It fits Hopper, Walker2d, HalfCheetah, Humanoid, HumanoidStandup, "
            "HumanoidStandupAndRun.",
        ),
        ("Hopper", [MovingGoal()], "MovingGoal does not fit Hopper. It fits Pusher."),
        (
            Task("Mine", "Hoper"),
            [],
            "gym_extensions/Mine-v0: There is no base body 'Hoper'. Did you mean 'Hopper'?",
        ),
    ],
)
def test_a_variation_or_a_base_that_does_not_fit_is_refused(
    task: object, variations: list, text: str
) -> None:
    with pytest.raises(BenchError) as caught:
        make(task, variations)
    assert str(caught.value) == text


def test_an_unknown_group_is_refused_with_the_closest_name() -> None:
    with pytest.raises(BenchError) as caught:
        group("hoper-gravity")
    assert str(caught.value) == "There is no group 'hoper-gravity'. Did you mean 'hopper-gravity'?"
