"""Actions of a wrong shape or type are rejected, in evaluation and in training."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gym_extensions.baselines import train
from gym_extensions.baselines.algorithms.zero import Zero
from gym_extensions.baselines.training.actions import clip_actions
from gym_extensions.envs import make_vec
from gym_extensions.errors import BenchError

HINT = "Return an array of numbers of shape (20, 3), one row per environment."
BAD_ACTIONS = [
    (None, "a value of type NoneType"),
    ("left", "a value of type str"),
    (0.5, "a value of type float"),
    (np.zeros((20, 2)), "an array of shape (20, 2) and dtype float64"),
    (np.zeros(3), "an array of shape (3,) and dtype float64"),
    ([[0.0] * 3] * 19 + [[0.0]], "a value of type list"),
    (np.full((20, 3), None), "an array of shape (20, 3) and dtype object"),
]


@pytest.mark.parametrize(("actions", "kind"), BAD_ACTIONS, ids=[kind for _, kind in BAD_ACTIONS])
def test_actions_of_another_shape_or_type_are_rejected(actions: Any, kind: str) -> None:
    with pytest.raises(BenchError) as error:
        clip_actions(actions, make_vec("Hopper", 20), "act()")
    assert str(error.value) == f"act(): The agent returned {kind} as actions. {HINT}"


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_actions_that_are_not_finite_are_rejected(value: float) -> None:
    actions = np.zeros((20, 3))
    actions[4, 1] = value
    message = (
        rf"^act\(\): The agent returned {value} as an action, in the row of environment 4\. Return finite"
    )
    with pytest.raises(BenchError, match=message):
        clip_actions(actions, make_vec("Hopper", 20), "act()")


def test_actions_are_clipped_to_the_action_space_and_cast_to_its_dtype() -> None:
    actions = clip_actions([[2, 0, -2]], make_vec("Hopper", 1), "act()")
    assert actions.dtype == np.float32
    assert actions.tolist() == [[1.0, 0.0, -1.0]]


class NarrowInEvaluation(Zero):
    def act(self, observations: Any) -> Any:
        return np.zeros((len(observations), 1))


class NarrowInTraining(Zero):
    def learn(self, env: Any, steps: int) -> None:
        env.reset()
        env.step(np.zeros((env.num_envs, 1)))


@pytest.mark.parametrize(
    ("agent", "message"),
    [
        (NarrowInEvaluation, r"task0: act\(\): The agent returned an array of shape \(20, 1\)"),
        (
            NarrowInTraining,
            r"task0: env\.step\(\) in learn\(\): The agent returned an array of shape \(1, 1\)",
        ),
    ],
)
def test_the_message_names_the_call_that_produced_the_actions(
    agent: Any, message: str, tmp_path: Path
) -> None:
    with pytest.raises(BenchError, match=message):
        train(agent, "hopper-gravity", "single", "smoke", 0, out=tmp_path)
