"""Copies and pickles continue exactly where the original is, and share nothing with it."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from gym_extensions import envs
from gym_extensions.envs.lifecycle import ClosedError

NAVIGATION = [
    "State-Based-Navigation-2d-Map0-Goal0",
    "State-Based-Navigation-2d-Map0-Goal0-KnownGoalPosition",
    "Limited-Range-Based-Navigation-2d-Map0-Goal0",
    "Limited-Range-Based-Navigation-2d-Map0-Goal0-KnownPositions",
    "Image-Based-Navigation-2d-Map0-Goal0",
]
BODIES = ["HopperNoisyWall", "HalfCheetahMotorNoise", "Humanoid", "HumanoidStandupAndRunWall"]
ARMS = ["PusherTrackingGoal", "StrikerTrackingGoal"]
WAYS: dict[str, Callable[[Any], Any]] = {
    "copy": copy.copy,
    "deepcopy": copy.deepcopy,
    "pickle": lambda env: pickle.loads(pickle.dumps(env)),  # noqa: S301
}


def actions(space: Any, steps: int) -> Any:
    """Random actions, (steps, …), float32."""
    return np.random.default_rng(1).uniform(space.low, space.high, (steps, *space.shape)).astype(np.float32)


def plain(result: Any) -> Any:
    """A result with its arrays as bytes."""
    if isinstance(result, dict):
        return {key: plain(value) for key, value in result.items()}
    return [plain(part) for part in result] if isinstance(result, tuple) else np.asarray(result).tobytes()


def trajectory(env: Any, actions: Any) -> list[Any]:
    """Everything that steps and two later resets return."""
    return [*(plain(env.step(row)) for row in actions), plain(env.reset()), plain(env.reset())]


@pytest.mark.parametrize("name", [*NAVIGATION, *BODIES, *ARMS])
def test_copies_of_a_vector_environment_continue_exactly(name: str) -> None:
    env: Any = envs.make_vec(name, 3)
    env.reset(seed=0)
    drawn = actions(env.action_space, 12)
    for row in drawn[:6]:
        env.step(row)
    copies = [make_copy(env) for make_copy in WAYS.values()]
    partial = {"options": {"reset_mask": np.array([False, True, False])}}
    expected = [plain(env.reset(**partial)), *trajectory(env, drawn[6:])]
    for copied in copies:
        assert [plain(copied.reset(**partial)), *trajectory(copied, drawn[6:])] == expected


@pytest.mark.parametrize("name", [*NAVIGATION, *BODIES, *ARMS])
def test_copies_of_an_environment_in_mid_episode_continue_exactly(name: str) -> None:
    env: Any = envs.make(name)
    env.reset(seed=0)
    drawn = actions(env.action_space, 12)
    for row in drawn[:6]:
        env.step(row)
    copies = [WAYS["deepcopy"](env), WAYS["pickle"](env)]
    bare = WAYS["copy"](env.unwrapped)
    expected = trajectory(env, drawn[6:])
    assert all(trajectory(copied, drawn[6:]) == expected for copied in copies)
    assert trajectory(bare, drawn[6:]) == expected


def test_a_copy_keeps_the_time_limit_and_the_end_of_an_episode() -> None:
    env: Any = envs.make_vec(envs.customize("HalfCheetah", max_steps=3), 1)
    env.reset(seed=0)
    drawn = actions(env.action_space, 5)
    env.step(drawn[0])
    copied = copy.deepcopy(env)
    assert [bool(copied.step(row)[3][0]) for row in drawn[1:]] == [False, True, False, False]


def test_a_closed_vector_environment_cannot_be_copied() -> None:
    env = envs.make_vec("Hopper", 2)
    env.close()
    with pytest.raises(ClosedError):
        copy.deepcopy(env)
