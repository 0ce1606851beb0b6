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

    def policy(self) -> Policy | None:
        return Policy(np.full(self.size, self.value()), np.ones(self.size))


class Wrong(Counting):
    """An agent whose policy is another after the first stage."""

    def policy(self) -> Policy | None:
        return Policy(np.full(self.size, 0.5), np.ones(self.size))


class Wide(Counting):
    """An agent whose policy is too large for a submission."""

    def policy(self) -> Policy | None:
        weights = np.random.default_rng(0).standard_normal((23, 1000)).astype(np.float32)
        layers = (weights, np.zeros((weights.shape[1], self.size), np.float32))
        biases = (np.zeros(weights.shape[1], np.float32), np.full(self.size, self.value(), np.float32))
        return Policy(np.zeros(self.size), np.ones(self.size), layers, biases)


def test_the_submission_has_the_policy_after_every_stage(tmp_path: Path) -> None:
    train(Counting, QUICK_GROUP, ["sequential", "single"], "smoke", 0, out=tmp_path)
    for protocol in ("sequential", "single"):
        policies = read_policies(tmp_path, QUICK_GROUP, protocol, 0)
        assert list(policies) == policy_keys(protocol, QUICK_GROUP)
        for (stage, _), policy in policies.items():
            assert isinstance(policy, Policy)
            assert float(policy.action_offset[0]) == 0.5 - stage / 10
    assert read(tmp_path, GROUPS, policies=True).problems == ()


class Sampling(Counting):
    """An agent whose card says that it does not sample."""

    def policy(self) -> Policy | None:
        return Policy(np.full(self.size, self.value()), np.ones(self.size), head="uniform")

    def card(self) -> Card:
        return Card("Sampling", evaluation="deterministic")


class Many(Counting):
    """An agent with a policy of more tasks than the group has."""

    observes = Observes(task_in_evaluation=True)

    def act(self, observations: Any, context: Any = None) -> Any:
        return super().act(observations)

    def policy(self) -> Policy | None:
        layers = (np.zeros((30, 23, self.size), np.float32),)
        return Policy(np.zeros(self.size), np.ones(self.size), layers, (np.full(self.size, self.value()),))


@pytest.mark.parametrize(
    ("agent", "message"),
    [
        (Wide, r"The policies of a run have .* bytes; the limit is 1,000"),
        (Sampling, "its head is 'uniform'"),
        (Many, "arrays for 30 tasks"),
    ],
)
def test_a_policy_that_a_submission_may_not_contain_is_refused_before_training(
    agent: Any, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(layout, "MAX_POLICY_BYTES", 1000)
    with pytest.raises(BenchError, match=message) as error:
        train(agent, QUICK_GROUP, "joint", "smoke", 0, out=tmp_path / "mine")
    assert error.value.code == "bad-policy"
    assert not (tmp_path / "mine").exists()


class Growing(Counting):
    """An agent whose policies become too large during training."""

    def policy(self) -> Policy | None:
        return Wide.policy(self) if self.stages else super().policy()  # type: ignore[arg-type]


def test_policies_that_grew_beyond_the_limit_are_kept_and_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(layout, "MAX_POLICY_BYTES", 200_000)
    for _ in range(2):  # the same command finds everything in place
        with pytest.raises(BenchError, match="policies of a run have") as error:
            train(Growing, QUICK_GROUP, "sequential", "smoke", 0, out=tmp_path)
    assert "delete the files policy*.npz" in error.value.hint
    for path in tmp_path.rglob("policy*.npz"):
        path.unlink()
    train(Growing, QUICK_GROUP, "sequential", "smoke", 0, out=tmp_path)
    assert read(tmp_path, GROUPS).problems == ()
    assert not list(tmp_path.rglob("*.npz"))


def test_a_policy_that_is_not_the_agents_stops_the_run(tmp_path: Path) -> None:
    with refused("policy-differs", "by 0.025 of the action range"):
        train(Wrong, QUICK_GROUP, "joint", "smoke", 0, out=tmp_path / "wrong")


def test_only_a_method_without_arguments_is_the_agents_policy() -> None:
    agent: Any = Counting(None, np.zeros((3, 1)), 0)
    agent.policy = type("Module", (), {"__call__": lambda self, states: states})()
    assert policy_of(agent) is None
    agent.policy = lambda observations: observations
    assert policy_of(agent) is None
    agent.policy = lambda: np.zeros(3)
    with pytest.raises(BenchError, match="ndarray"):
        policy_of(agent)
