"""Policies are compared with the agent's actions and stored after every stage."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gym_extensions.baselines import Card, Observes, train
from gym_extensions.baselines.agent import policy_of
from gym_extensions.catalog.groups import with_custom
from gym_extensions.errors import BenchError
from gym_extensions.submissions import layout
from gym_extensions.submissions.policies.files import policy_keys, read_policies
from gym_extensions.submissions.policies.mlp import Policy
from gym_extensions.submissions.reader import read

from ...conftest import refused
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

    def policy(self, **changes: Any) -> Policy | None:
        return Policy(np.full(self.size, self.value()), np.ones(self.size), **changes)


def counting(**changes: Any) -> Any:
    """Such agents with other methods or attributes."""
    return type("Mine", (Counting,), changes)


def wide(agent: Any) -> Policy:
    """A policy that is too large for a submission of the tests."""
    weights = np.random.default_rng(0).standard_normal((23, 1000)).astype(np.float32)
    layers = (weights, np.zeros((1000, agent.size), np.float32))
    biases = (np.zeros(1000, np.float32), np.full(agent.size, agent.value(), np.float32))
    return Policy(np.zeros(agent.size), np.ones(agent.size), layers, biases)


SAMPLING = counting(
    policy=lambda self: Counting.policy(self, head="uniform"),
    card=lambda self: Card("Sampling", evaluation="deterministic"),
)
MANY = counting(
    observes=Observes(task_in_evaluation=True),
    act=lambda self, observations, context=None: Counting.act(self, observations),
    policy=lambda self: Policy(
        np.zeros(7), np.ones(7), (np.zeros((30, 23, 7), np.float32),), (np.full(7, self.value()),)
    ),
)
NARROW = counting(
    policy=lambda _: Policy(np.zeros(7), np.ones(7), (np.zeros((11, 7), np.float32),), (np.zeros(7),))
)


def test_the_submission_has_the_policy_after_every_stage(tmp_path: Path) -> None:
    train(Counting, QUICK_GROUP, ["sequential", "single"], "smoke", 0, out=tmp_path)
    for protocol in ("sequential", "single"):
        policies = read_policies(tmp_path, QUICK_GROUP, protocol, 0)
        assert list(policies) == policy_keys(protocol, QUICK_GROUP)
        for (stage, _), policy in policies.items():
            assert isinstance(policy, Policy)
            assert float(policy.action_offset[0]) == 0.5 - stage / 10
    assert read(tmp_path, GROUPS, policies=True).problems == ()


@pytest.mark.parametrize(
    ("agent", "message"),
    [
        (counting(policy=wide), "bytes; the limit is 1,000"),
        (SAMPLING, "its head is 'uniform'"),
        (MANY, "arrays for 30 tasks"),
        (NARROW, "has 11 inputs and 7 actions; an observation has 23 values"),
        (counting(policy=lambda _: Policy(np.zeros(6), np.ones(6))), "has no inputs and 6 actions"),
    ],
)
def test_a_policy_that_a_submission_may_not_contain_is_refused_before_training(
    agent: Any, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(layout, "MAX_POLICY_BYTES", 1000)
    with refused("bad-policy", message):
        train(agent, QUICK_GROUP, "joint", "smoke", 0, out=tmp_path / "mine")
    assert not (tmp_path / "mine").exists()


def test_a_policy_with_rows_for_too_many_tasks_stops_the_run_after_its_stage(tmp_path: Path) -> None:
    later = counting(**vars(MANY) | {"policy": lambda self: MANY.policy(self) if self.stages else None})
    with refused("bad-policy", "arrays for 30 tasks"):
        train(later, QUICK_GROUP, "sequential", "smoke", 0, out=tmp_path / "mine")


@pytest.mark.parametrize("is_later", [True, False])
def test_a_policy_in_some_stages_stops_the_run_after_the_first_of_the_others(
    is_later: bool, tmp_path: Path
) -> None:
    some = counting(policy=lambda self: Counting.policy(self) if bool(self.stages) == is_later else None)
    with refused("bad-policy", "Only some stages have a policy"):
        train(some, QUICK_GROUP, "sequential", "smoke", 0, out=tmp_path)
    assert [path.name for path in tmp_path.rglob("stage*.json")] == ["stage0.json"]
    train(some, QUICK_GROUP, "joint", "smoke", 0, out=tmp_path / "joint")


def test_policies_that_grew_too_large_are_kept_and_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(layout, "MAX_POLICY_BYTES", 200_000)
    growing = counting(policy=lambda self: wide(self) if self.stages else Counting.policy(self))
    for _ in range(2):  # the same command finds everything in place
        with pytest.raises(BenchError, match="policies of a run have") as error:
            train(growing, QUICK_GROUP, "sequential", "smoke", 0, out=tmp_path)
    assert "delete the files policy*.npz" in error.value.hint
    for path in tmp_path.rglob("policy*.npz"):
        path.unlink()
    train(growing, QUICK_GROUP, "sequential", "smoke", 0, out=tmp_path)
    assert read(tmp_path, GROUPS).problems == ()
    assert not list(tmp_path.rglob("*.npz"))


def test_a_policy_that_is_not_the_agents_stops_the_run(tmp_path: Path) -> None:
    wrong = counting(policy=lambda self: Policy(np.full(self.size, 0.5), np.ones(self.size)))
    with refused("policy-differs", "by 0.025 of the action range"):
        train(wrong, QUICK_GROUP, "joint", "smoke", 0, out=tmp_path / "wrong")


def test_only_a_method_without_arguments_is_the_agents_policy() -> None:
    agent: Any = Counting(None, np.zeros((3, 1)), 0)
    agent.policy = type("Module", (), {"__call__": lambda self, states: states})()
    assert policy_of(agent) is None
    agent.policy = lambda observations: observations
    assert policy_of(agent) is None
    agent.policy = lambda: np.zeros(3)
    with pytest.raises(BenchError, match="ndarray"):
        policy_of(agent)
