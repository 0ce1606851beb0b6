"""A policy made of PyTorch's layers acts as the networks do."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
import pytest
import torch
from stable_baselines3 import PPO, SAC
from torch import nn

from gym_extensions.baselines.adapters.sb3_policy import ACTIVATIONS, policy_layers
from gym_extensions.baselines.adapters.sb3_vec_env import SpacesVecEnv
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.policy import Policy

OBSERVATIONS = gym.spaces.Box(-np.inf, np.inf, (5,), np.float64)
ACTIONS = gym.spaces.Box(-0.4, 0.6, (2,), np.float32)
SEEN = np.random.default_rng(0).standard_normal((50, 5))
ONES, ZEROS = np.ones(2, np.float32), np.zeros(2, np.float32)


@pytest.mark.parametrize("activation", ACTIVATIONS)
def test_every_activation_is_the_same_function(activation: type[nn.Module]) -> None:
    torch.manual_seed(0)
    network = nn.Sequential(nn.Linear(5, 16), activation(), nn.Linear(16, 2))
    policy = Policy(ZEROS, ONES, **policy_layers(network))
    expected = network(torch.tensor(10 * SEEN, dtype=torch.float32)).detach().numpy()
    np.testing.assert_allclose(policy.act(10 * SEEN), expected, rtol=1e-5, atol=1e-5)


def test_ppo_of_stable_baselines3() -> None:
    model: Any = PPO("MlpPolicy", SpacesVecEnv(OBSERVATIONS, ACTIONS, 1), device="cpu", seed=0)
    networks = (model.policy.mlp_extractor.policy_net, model.policy.action_net)
    policy = Policy(ZEROS, ONES, **policy_layers(*networks))
    expected = model.predict(SEEN, deterministic=True)[0]
    actions = np.clip(policy.act(SEEN), ACTIONS.low, ACTIONS.high)
    np.testing.assert_allclose(actions, expected, atol=1e-6)


def test_sac_of_stable_baselines3_with_its_head_for_sigma() -> None:
    spaces = SpacesVecEnv(OBSERVATIONS, ACTIONS, 1)
    model: Any = SAC(
        "MlpPolicy", spaces, device="cpu", seed=0, buffer_size=10, policy_kwargs={"net_arch": [64, 64]}
    )
    actor = model.policy.actor
    sigma = policy_layers(actor.log_std)
    policy = Policy(
        action_offset=(ACTIONS.high + ACTIONS.low) / 2,
        action_scale=(ACTIONS.high - ACTIONS.low) / 2,
        **policy_layers(actor.latent_pi, actor.mu),
        squash="tanh",
        log_sigma=sigma["biases"][0],
        log_sigma_weight=sigma["weights"][0],
        log_sigma_clip=np.array([-20.0, 2.0], np.float32),
    )
    np.testing.assert_allclose(policy.act(SEEN), model.predict(SEEN, deterministic=True)[0], atol=1e-6)


@pytest.mark.parametrize(
    ("modules", "message"),
    [
        ([nn.Linear(2, 2), nn.LayerNorm(2), nn.Linear(2, 2)], "LayerNorm cannot be part of a policy."),
        ([nn.Linear(2, 2), nn.Linear(2, 2)], "The modules are Linear, Linear."),
        (
            [nn.Linear(2, 2), nn.Tanh(), nn.Linear(2, 2), nn.ReLU(), nn.Linear(2, 2)],
            "The modules are Linear, Tanh, Linear, ReLU, Linear.",
        ),
    ],
)
def test_other_networks_are_refused(modules: list[nn.Module], message: str) -> None:
    with pytest.raises(BenchError) as error:
        policy_layers(*modules)
    assert error.value.message == message
