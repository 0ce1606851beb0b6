"""Actions that are refused."""

from __future__ import annotations

import numpy as np
import pytest

from gym_extensions.envs import make, make_vec
from gym_extensions.errors import BenchError

TASK = "State-Based-Navigation-2d-Map2-Goal1"
ID = f"gym_extensions/{TASK}-v0"
HINT_SHAPE = "Give one number per actuator."


@pytest.mark.parametrize(
    ("action", "message"),
    [
        (np.array([np.nan, 0.0]), f"{ID}: action[0] is nan. Give finite numbers."),
        (np.array([0.0, np.inf]), f"{ID}: action[1] is inf. Give finite numbers."),
        (np.zeros(3), f"{ID}: The action has shape (3,), not (2,). {HINT_SHAPE}"),
        (np.zeros((1, 2)), f"{ID}: The action has shape (1, 2), not (2,). {HINT_SHAPE}"),
        (1.0, f"{ID}: The action has shape (), not (2,). {HINT_SHAPE}"),
    ],
)
def test_an_action_of_another_shape_or_with_nan_is_refused_and_moves_nothing(
    action: object, message: str
) -> None:
    env = make(TASK).unwrapped
    env.reset(seed=0)
    before = env.save_state()["position"]
    with pytest.raises(BenchError) as refused:
        env.step(action)
    assert refused.value.code == "bad-action"
    assert str(refused.value) == message
    assert env.save_state()["position"].tolist() == before.tolist()


def test_a_batch_refuses_a_bad_action_too() -> None:
    env = make_vec(TASK, 3)
    env.reset(seed=0)
    with pytest.raises(BenchError, match=r"action\[1, 0\] is nan"):
        env.step(np.array([[0, 0], [np.nan, 0], [0, 0]]))
    with pytest.raises(BenchError, match=r"shape \(2,\), not \(3, 2\)"):
        env.step(np.zeros(2))
