"""The reference agents and the properties that all of them have."""

import copy
import sys
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gym_extensions.baselines import Resumable, algorithms
from gym_extensions.baselines.agent import Described
from gym_extensions.baselines.agent_spec import checked_card
from gym_extensions.baselines.training.environment import TrainingEnv
from gym_extensions.envs import make_vec
from gym_extensions.errors import BenchError
from gym_extensions.submissions.policies.mlp import Policy

from ...conftest import refused

NUMPY = [name for name in algorithms.names() if name.partition("-")[0] not in ("ppo", "sac", "sac64")]
"""The agents without optional packages; ``test_ppo_and_sac`` and ``test_additions`` test the others."""
Spaces = tuple[Any, Any]


@pytest.fixture(scope="module")
def spaces() -> Spaces:
    env = make_vec("Pusher", 1)
    return env.single_observation_space, env.single_action_space


@pytest.mark.parametrize("name", NUMPY)
def test_each_describes_itself_can_be_saved_and_repeats_itself_by_its_seed(name: str, spaces: Spaces) -> None:
    agent, twin = (algorithms.factory(name)(*spaces, 7) for _ in range(2))
    assert isinstance(agent, Described)
    assert isinstance(twin, Resumable)
    assert checked_card(agent, "other").algorithm == name
    observations = np.zeros((4, *spaces[0].shape))
    first, second = (each.act(observations) for each in (agent, twin))
    assert first.shape == (4, *spaces[1].shape)
    assert np.array_equal(first, second)


def test_random_is_uniform_over_the_action_space(spaces: Spaces) -> None:
    actions = algorithms.factory("random")(*spaces, 0).act(np.zeros((2000, *spaces[0].shape)))
    low, high = spaces[1].low, spaces[1].high
    assert ((actions >= low) & (actions <= high)).all()
    np.testing.assert_allclose(actions.mean(axis=0), (low + high) / 2, atol=0.1 * high.max())
    np.testing.assert_allclose(actions.std(axis=0), (high - low) / np.sqrt(12), rtol=0.05)


def test_zero_returns_zeros(spaces: Spaces) -> None:
    observations = np.ones((3, *spaces[0].shape))
    actions = algorithms.factory("zero")(*spaces, 0).act(observations)
    assert np.array_equal(actions, np.zeros((3, *spaces[1].shape)))


def make(observation_space: Any, action_space: Any, seed: int) -> Any:
    raise NotImplementedError


@pytest.mark.parametrize(
    ("agent", "name"),
    [
        ("trpo", "trpo"),
        (algorithms.factory("zero"), "Zero"),
        ("my.module:Climber", "Climber"),
        ("my.module:make", "module"),
        (make, "test_reference_agents"),
        (partial(make), "test_reference_agents"),
    ],
)
def test_an_agent_without_a_card_is_named_after_its_factory_or_module(agent: Any, name: str) -> None:
    assert algorithms.name_of(agent) == name


def test_an_agent_may_be_named_by_its_file(tmp_path: Path) -> None:
    for folder in ("one", "other"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "climber_file.py").write_text("def make(*spaces_and_seed):\n    return None\n")
    agent = f"{tmp_path}/one/climber_file.py:make"
    assert algorithms.factory(agent).__module__ == algorithms.name_of(agent) == "climber_file"
    for path, message in (
        ("other/climber_file.py", "Python has another module 'climber_file'"),
        ("none.py", "There is no file"),
    ):
        with pytest.raises(BenchError, match=message):
            algorithms.factory(f"{tmp_path}/{path}:make")


@pytest.mark.parametrize("name", ["trpo", "trpo-2017", "zero"])
def test_the_stored_policy_acts_like_the_agent_up_to_rounding(name: str, spaces: Spaces) -> None:
    agent: Any = algorithms.factory(name)(*spaces, 3)
    states = np.random.default_rng(0).standard_normal((20, *spaces[0].shape))
    for steps in (0, 250):  # untrained, and with normalized observations
        if steps:
            env = TrainingEnv(make_vec("Pusher", 2), ["Pusher"], steps=steps, batch_steps=250, seed=0)
            agent.learn(env, steps)
        policy = Policy.from_arrays(agent.policy().arrays())
        noise = copy.deepcopy(getattr(agent, "_acting", None))
        np.testing.assert_allclose(policy.act(states, noise), agent.act(states), rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize(("name", "package", "extra"), [("ppo", "torch", "sb3"), ("sac", "sbx", "sbx")])
def test_a_missing_package_is_named_with_the_command_that_installs_it(
    name: str, package: str, extra: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delitem(sys.modules, f"gym_extensions.baselines.algorithms.{name}", raising=False)
    for module in [each for each in sys.modules if each.startswith("gym_extensions.baselines.adapters.sb3")]:
        monkeypatch.delitem(sys.modules, module)
    monkeypatch.setitem(sys.modules, package, None)
    if package == "torch":
        monkeypatch.setitem(sys.modules, "stable_baselines3", None)
    missing = "stable_baselines3" if package == "torch" else package
    with refused("missing-extra", missing, f"gym-extensions[{extra}]"):
        algorithms.factory(name)
