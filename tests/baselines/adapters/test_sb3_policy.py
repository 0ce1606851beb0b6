"""Policies of Stable-Baselines3 and SBX models as plain arrays."""

from __future__ import annotations

import sys
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

pytest.importorskip("stable_baselines3")

import torch
from stable_baselines3 import A2C, PPO, SAC, TD3
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor

from gym_extensions.baselines import sb3
from gym_extensions.baselines.adapters.sb3_policy import exported, unsupported
from gym_extensions.baselines.adapters.sb3_vec_env import SpacesVecEnv
from gym_extensions.baselines.training.evaluation import Evaluator
from gym_extensions.catalog.groups import group
from gym_extensions.errors import BenchError
from gym_extensions.verification.episodes import Cell, Player

OBSERVATIONS = gym.spaces.Box(-np.inf, np.inf, (5,), np.float64)
ACTIONS = gym.spaces.Box(np.array([-1, -3], np.float32), np.array([1, 5], np.float32))
NETWORK: dict[str, Any] = {"net_arch": [8, 6]}
MODELS: dict[str, tuple[Any, dict[str, Any]]] = {
    "PPO": (PPO, {}),
    "A2C with ELU": (A2C, {"activation_fn": torch.nn.ELU}),
    "SAC": (SAC, {}),
    "TD3": (TD3, {"activation_fn": torch.nn.LeakyReLU}),
}


def model(name: str) -> Any:
    """A model whose initial parameters are all different from 0."""
    algorithm, network = MODELS[name]
    created = algorithm("MlpPolicy", SpacesVecEnv(OBSERVATIONS, ACTIONS, 1), policy_kwargs=NETWORK | network)
    with torch.no_grad():
        for values in created.policy.parameters():
            values.add_(0.1 * torch.randn(values.shape))
    return created


@pytest.mark.parametrize("name", MODELS)
def test_the_policy_acts_as_the_model(name: str) -> None:
    trained = model(name)
    observations = np.random.default_rng(0).normal(size=(20, 5)).astype(np.float32)
    expected, _ = trained.predict(observations, deterministic=True)
    actions = np.clip(exported(trained).act(observations), ACTIONS.low, ACTIONS.high)
    np.testing.assert_allclose(actions, expected, rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize("name", ["PPO", "SAC"])
def test_samples_have_the_model_s_distribution(name: str) -> None:
    trained = model(name)
    observations = np.tile(np.random.default_rng(0).normal(size=5).astype(np.float32), (4000, 1))
    expected, _ = trained.predict(observations, deterministic=False)
    actions = exported(trained, deterministic=False).act(observations, np.random.default_rng(1))
    actions = np.clip(actions, ACTIONS.low, ACTIONS.high)
    np.testing.assert_allclose(actions.mean(axis=0), expected.mean(axis=0), atol=0.15)
    np.testing.assert_allclose(actions.std(axis=0), expected.std(axis=0), rtol=0.08)


def test_the_statistics_of_the_observations_belong_to_the_policy() -> None:
    make = sb3(PPO, normalize_observations=True, policy_kwargs=NETWORK, n_steps=16, batch_size=16)
    agent: Any = make(OBSERVATIONS, ACTIONS, 0)
    statistics = agent._normalization._wrapper.obs_rms
    statistics.mean, statistics.var = np.arange(5.0), np.arange(1.0, 6.0)
    observations = np.random.default_rng(0).normal(scale=30, size=(20, 5))
    actions = np.clip(agent.policy().act(observations), ACTIONS.low, ACTIONS.high)
    np.testing.assert_allclose(actions, agent.act(observations), rtol=1e-5, atol=1e-5)


def test_a_policy_that_cannot_be_expressed_trains_without_one_and_is_named_on_export() -> None:
    agent: Any = sb3(PPO, use_sde=True)(OBSERVATIONS, ACTIONS, 0)
    with pytest.warns(UserWarning, match="stays claimed"):
        assert agent.policy() is None
    with pytest.raises(BenchError, match="use_sde"):
        exported(agent._model)


def test_without_the_extra_a_network_is_not_stored_and_the_warning_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(sys.modules, "onnx", None)
    agent: Any = sb3(PPO, policy_kwargs={"activation_fn": torch.nn.GELU})(OBSERVATIONS, ACTIONS, 0)
    with pytest.warns(UserWarning, match=r"gym-extensions\[onnx\]"):
        assert agent.policy() is None


def test_the_logged_episodes_are_those_that_a_verifier_repeats() -> None:
    members = group("hopper-wall")
    evaluator, player = Evaluator(members), Player(members)
    env = evaluator.envs(members.tasks[1])
    agent: Any = sb3(PPO)(env.single_observation_space, env.single_action_space, 0)
    logged = evaluator.evaluate(agent, 0, members.tasks[1], agent.policy())
    seeds = tuple(episode.seed for episode in logged)
    repeated = player.outcomes(agent.policy(), Cell(0, 1, seeds))
    assert [episode.return_ for episode in logged] == [outcome.return_ for outcome in repeated]
    player.close()
    evaluator.close()


class Normalized(BaseFeaturesExtractor):
    """A features extractor as wide as the observations."""

    def __init__(self, space: Any) -> None:
        super().__init__(space, space.shape[0])
        self.layer = torch.nn.LayerNorm(space.shape[0])

    def forward(self, observations: Any) -> Any:
        return self.layer(observations)


@pytest.mark.parametrize("algorithm", [PPO, SAC])
def test_a_policy_with_a_features_extractor_of_the_user_is_not_plain(algorithm: Any) -> None:
    arguments: dict[str, Any] = {"policy_kwargs": {"features_extractor_class": Normalized}}
    created = algorithm("MlpPolicy", SpacesVecEnv(OBSERVATIONS, ACTIONS, 1), **arguments)
    assert "features extractor" in unsupported(created)
