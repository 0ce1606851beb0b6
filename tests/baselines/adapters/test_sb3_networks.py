"""Policies of Stable-Baselines3 that are no multilayer perceptron are stored as ONNX networks."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
import pytest

pytest.importorskip("stable_baselines3")
pytest.importorskip("onnx", reason="needs the extra onnx")
pytest.importorskip("onnxruntime", reason="needs the extra onnx")

import torch
from stable_baselines3 import PPO, SAC, TD3
from stable_baselines3.common.policies import ActorCriticPolicy
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor

from gym_extensions.baselines import sb3
from gym_extensions.rollouts.onnx_policy import OnnxPolicy

OBSERVATIONS = gym.spaces.Box(-np.inf, np.inf, (5,), np.float64)
ACTIONS = gym.spaces.Box(np.array([-1, -3], np.float32), np.array([1, 5], np.float32))
IMAGES = gym.spaces.Box(0, 255, (36, 40, 3), np.uint8)


class Extractor(BaseFeaturesExtractor):
    """An own extractor of features."""

    def __init__(self, space: Any) -> None:
        super().__init__(space, 4)
        width = space.shape[0]
        self.layers = torch.nn.Sequential(torch.nn.LayerNorm(width), torch.nn.Linear(width, 4))

    def forward(self, observations: Any) -> Any:
        return self.layers(observations)


class Own(ActorCriticPolicy):
    """An own class of policies."""

    def __init__(self, *arguments: Any, **settings: Any) -> None:
        super().__init__(*arguments, **(settings | {"features_extractor_class": Extractor}))


EXTRACTED: dict[str, Any] = {"policy_kwargs": {"features_extractor_class": Extractor}}
CASES: dict[str, tuple[Any, dict[str, Any], gym.spaces.Box]] = {
    "PPO, own extractor": (PPO, EXTRACTED, OBSERVATIONS),
    "PPO, own extractor, normalized": (PPO, EXTRACTED | {"normalize_observations": True}, OBSERVATIONS),
    "PPO, own class": (PPO, {"policy": Own}, OBSERVATIONS),
    "SAC, own extractor": (SAC, EXTRACTED | {"buffer_size": 10}, OBSERVATIONS),
    "TD3, own extractor": (TD3, EXTRACTED | {"buffer_size": 10}, OBSERVATIONS),
    "PPO, images": (PPO, {"policy": "CnnPolicy"}, IMAGES),
}


@pytest.mark.parametrize("case", CASES)
def test_the_network_acts_as_the_model(case: str) -> None:
    algorithm, settings, space = CASES[case]
    agent: Any = sb3(algorithm, **settings)(space, ACTIONS, 0)
    observations = np.stack([space.sample() for _ in range(4)])
    policy = agent.policy()
    assert isinstance(policy, OnnxPolicy)
    actions = np.clip(policy.act(observations), ACTIONS.low, ACTIONS.high)
    np.testing.assert_allclose(actions, agent.act(observations), rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize("algorithm", [PPO, SAC])
def test_samples_have_the_model_s_distribution(algorithm: Any) -> None:
    agent: Any = sb3(algorithm, deterministic=False, **EXTRACTED)(OBSERVATIONS, ACTIONS, 0)
    observations = np.tile(OBSERVATIONS.sample(), (4000, 1))
    expected = agent.act(observations)
    actions = np.clip(agent.policy().act(observations, np.random.default_rng(0)), ACTIONS.low, ACTIONS.high)
    np.testing.assert_allclose(actions.mean(axis=0), expected.mean(axis=0), atol=0.15)
    np.testing.assert_allclose(actions.std(axis=0), expected.std(axis=0), rtol=0.08)
