"""The forms of a policy that is recorded: functions, models, plain arrays, and what is none."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gym_extensions.baselines import Observes
from gym_extensions.catalog.custom_groups import with_custom
from gym_extensions.rollouts.policies import Policy
from gym_extensions.rollouts.reader import read

from ..conftest import QUICK_GROUP
from .recordings import CARD, GROUP, TASKS, logged, message, push, record_stage, zero

OFFSET_AND_SCALE = np.zeros(7, np.float32), np.ones(7, np.float32)


class Model:
    """A recurrent model with the method of Stable-Baselines3: its action grows by 0.01 per step."""

    def __init__(self) -> None:
        self.calls: list[tuple[bool, bool]] = []

    def predict(self, observation: Any, state: Any, episode_start: Any, deterministic: bool) -> Any:
        self.calls.append((bool(episode_start.all()), deterministic))
        assert (state is None) == bool(episode_start.all())
        steps = 0 if state is None else state + 1
        return np.full((len(observation), 7), steps / 100), steps


def test_a_model_of_stable_baselines3_keeps_its_state_within_a_task(tmp_path: Path) -> None:
    model = Model()
    record_stage(tmp_path / "mine", model, protocol="joint")
    starts = [start for start, _ in model.calls]
    assert starts == ([True] + [False] * 9) * 2
    assert {deterministic for _, deterministic in model.calls} == {True}


def test_a_policy_of_plain_arrays_samples_the_same_each_time_and_is_stored(tmp_path: Path) -> None:
    uniform = Policy(np.zeros(7), np.ones(7), head="uniform")
    card = replace(CARD, evaluation="sampled")
    first, second = (
        record_stage(tmp_path / name, uniform, "joint", card=card) for name in ("first", "second")
    )
    assert first == second
    stored = tmp_path / "first" / GROUP / "policies" / "joint-run0-stage1.npz"
    assert stored.read_bytes() == uniform.to_bytes()
    assert first != record_stage(tmp_path / "first", uniform, "joint", card=card, run=1)


SHAPES = "observations of shape (20, 23) and dtype float64"
BAD_POLICIES: dict[str, tuple[Any, str]] = {
    "wrong actions": (
        lambda observations: np.zeros((len(observations), 2)),
        "act(): The agent returned an array of shape (20, 2) and dtype float64 as actions. Return an array "
        "of numbers of shape (20, 7), one row per environment.",
    ),
    "wrong observations": (
        lambda observations: observations @ np.zeros((11, 7)),
        f"policy: The policy failed on {SHAPES}: ValueError: matmul: ",
    ),
    "not a policy": (
        "policy.pt",
        "policy: A value of type str is not a policy. Use a function from observations (n, …) to actions (n, "
        "…), or an object with a method act or predict.",
    ),
}


@pytest.mark.parametrize("name", BAD_POLICIES)
def test_a_policy_of_the_wrong_shapes_is_refused_and_nothing_is_lost(name: str, tmp_path: Path) -> None:
    out = tmp_path / "mine"
    policy, text = BAD_POLICIES[name]
    assert message(out, policy, "joint").startswith(text)
    record_stage(out, protocol="joint")
    assert len(logged(out, "joint")) == 40


def test_policies_that_get_a_head_per_task_while_they_are_trained(tmp_path: Path) -> None:
    observes = Observes(True, True)
    for stage in range(len(TASKS) + 1):
        tasks = (stage,) if stage else ()
        weights, biases = np.zeros((*tasks, 23, 7), np.float32), np.zeros((*tasks, 7), np.float32)
        policy = Policy(*OFFSET_AND_SCALE, weights=(weights,), biases=(biases,))
        record_stage(tmp_path, policy, stage=stage, observes=observes)
    assert not read(tmp_path, with_custom([QUICK_GROUP])).problems


def test_the_policy_of_an_earlier_attempt_is_not_published(tmp_path: Path) -> None:
    policy = Policy(*OFFSET_AND_SCALE)
    for task in TASKS:
        record_stage(tmp_path, policy, "single", task=task.name)
        if task is TASKS[0]:
            record_stage(tmp_path, zero, "single", task=task.name)
    assert not (tmp_path / GROUP / "policies").exists()


def test_a_log_with_a_run_without_policies_has_none(tmp_path: Path) -> None:
    policy = Policy(*OFFSET_AND_SCALE)
    for task in TASKS:
        record_stage(tmp_path, policy, "single", task=task.name)
    assert len(list((tmp_path / GROUP / "policies").iterdir())) == len(TASKS)
    for task in TASKS:
        record_stage(tmp_path, push, "single", run=1, task=task.name)
    assert not (tmp_path / GROUP / "policies").exists()
    assert not read(tmp_path, with_custom([QUICK_GROUP])).problems
