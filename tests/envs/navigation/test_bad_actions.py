"""Invalid actions."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from gym_extensions.catalog.registry import task
from gym_extensions.envs import make_vec
from gym_extensions.envs.navigation.build import construct as construct_navigation
from gym_extensions.errors import BenchError

TASK = "State-Based-Navigation-2d-Map2-Goal1"
ID = f"gym_extensions/{TASK}-v0"
SHAPE_HINT = "Give one number per actuator."


@pytest.mark.parametrize(
    ("action", "message"),
    [
        (np.array([np.nan, 0.0]), f"{ID}: action[0] is nan. Give finite numbers."),
        (np.array([0.0, np.inf]), f"{ID}: action[1] is inf. Give finite numbers."),
        (np.zeros(3), f"{ID}: The action has shape (3,); expected (2,). {SHAPE_HINT}"),
        (np.zeros((1, 2)), f"{ID}: The action has shape (1, 2); expected (2,). {SHAPE_HINT}"),
        (1.0, f"{ID}: The action has shape (); expected (2,). {SHAPE_HINT}"),
    ],
)
def test_an_invalid_action_raises_an_error_and_moves_nothing(action: Any, message: str) -> None:
    env = construct_navigation(task(TASK))
    env.reset(seed=0)
    before = env.save_state()["position"]
    with pytest.raises(BenchError) as caught:
        env.step(action)
    assert caught.value.code == "bad-action"
    assert str(caught.value) == message
    assert env.save_state()["position"].tolist() == before.tolist()


def test_the_vector_environment_checks_actions_too() -> None:
    env = make_vec(TASK, 3)
    env.reset(seed=0)
    with pytest.raises(BenchError, match=r"action\[1, 0\] is nan"):
        env.step(np.array([[0, 0], [np.nan, 0], [0, 0]]))
    with pytest.raises(BenchError, match=r"shape \(2,\); expected \(3, 2\)"):
        env.step(np.zeros(2))
