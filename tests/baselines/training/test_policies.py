"""Policies are compared with the agent's actions and stored after every stage."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gym_extensions.baselines import train
from gym_extensions.baselines.training.policies import policy_of
from gym_extensions.catalog.custom_groups import with_custom
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.layout import MAX_POLICY_BYTES
from gym_extensions.rollouts.policies import Policy
from gym_extensions.rollouts.reader import read

from ..conftest import QUICK_GROUP

GROUPS = with_custom([QUICK_GROUP])


class Counting:
    """An agent whose constant action depends on the number of trained stages, with its policy."""

    def __init__(self, observation_space: Any, action_space: Any, seed: int) -> None:
        self.size, self.stages, self.stops = action_space.shape[0], 0, False

    def value(self) -> float:
        return 0.5 - self.stages / 10

    def act(self, observations: Any) -> Any:
        return np.full((len(observations), self.size), self.value())

    def learn(self, env: Any, steps: int) -> None:
        self.stages += 1

    def policy(self) -> Policy | None:
        return Policy(np.full(self.size, self.value()), np.ones(self.size))


class Wrong(Counting):
    """An agent whose policy is another after the first stage."""

    def policy(self) -> Policy | None:
        return Policy(np.full(self.size, 0.5), np.ones(self.size))


class Recurrent(Counting):
    """An agent whose policy is not a multilayer perceptron."""

    def policy(self) -> Policy | None:
        return None


class Wide(Counting):
    """An agent whose policy is too large for a submission."""

    def policy(self) -> Policy | None:
        weights = np.random.default_rng(0).standard_normal((23, MAX_POLICY_BYTES // 36)).astype(np.float32)
        layers = (weights, np.zeros((weights.shape[1], self.size), np.float32))
        biases = (np.zeros(weights.shape[1], np.float32), np.full(self.size, self.value(), np.float32))
        return Policy(np.zeros(self.size), np.ones(self.size), layers, biases)


def test_the_submission_has_the_policy_after_every_stage(tmp_path: Path) -> None:
    train(Counting, QUICK_GROUP, ["sequential", "single"], "smoke", 0, out=tmp_path / "counting")
    folder = tmp_path / "counting" / QUICK_GROUP.name / "policies"
    actions = {
        path.name: float(Policy.from_bytes(path.read_bytes()).action_offset[0])
        for path in sorted(folder.iterdir())
    }
    assert actions == {
        f"{protocol}-run0-stage{stage}{task}.npz": 0.5 - stage / 10
        for protocol, stages, tasks in (
            ("sequential", (0, 1, 2), [""]),
            ("single", (1,), [f"-{task.name}" for task in QUICK_GROUP.tasks]),
        )
        for stage in stages
        for task in tasks
    }
    assert read(tmp_path / "counting", GROUPS).problems == ()


def test_an_added_run_adds_its_policies(tmp_path: Path) -> None:
    out = tmp_path / "added"
    for run in (0, 1):
        train(Counting, QUICK_GROUP, "joint", "smoke", run, out=out)
    policies = sorted(path.name for path in (out / QUICK_GROUP.name / "policies").iterdir())
    assert policies == ["joint-run0-stage1.npz", "joint-run1-stage1.npz"]
    assert read(out, GROUPS).problems == ()


def test_runs_without_policies_keep_those_of_later_runs_out_of_the_submission(tmp_path: Path) -> None:
    for make, run in ((Recurrent, 0), (Counting, 1)):
        make.__name__ = "agent"
        train(make, QUICK_GROUP, "joint", "smoke", run, out=tmp_path / "mixed")
    assert not (tmp_path / "mixed" / QUICK_GROUP.name / "policies").exists()
    assert (tmp_path / "mixed/.progress" / QUICK_GROUP.name / "policies/joint-run1-stage1.npz").exists()


def test_a_policy_above_the_limit_is_left_out(tmp_path: Path) -> None:
    train(Wide, QUICK_GROUP, "joint", "smoke", 0, out=tmp_path / "without")
    assert not (tmp_path / "without" / QUICK_GROUP.name / "policies").exists()
    assert read(tmp_path / "without", GROUPS).problems == ()


def test_a_policy_that_is_not_the_agents_stops_the_run(tmp_path: Path) -> None:
    with pytest.raises(BenchError) as error:
        train(Wrong, QUICK_GROUP, "joint", "smoke", 0, out=tmp_path / "wrong")
    assert str(error.value) == (
        "policy(): The policy's actions differ from those of act() by 0.05 half widths. "
        "Return the policy that act() uses, or None if it cannot be expressed as plain arrays."
    )


def test_only_a_method_is_the_agents_policy() -> None:
    agent: Any = Counting(None, np.zeros((3, 1)), 0)
    agent.policy = type("Module", (), {"__call__": lambda self, states: states})()
    assert policy_of(agent) is None
    agent.policy = lambda: np.zeros(3)
    with pytest.raises(BenchError) as error:
        policy_of(agent)
    assert str(error.value) == (
        "policy(): Expected a Policy or None, got a value of type ndarray. "
        "Return a gym_extensions.rollouts.policies.Policy."
    )
