"""Policies of Stable-Baselines3 models as plain arrays or as ONNX networks, and layers of PyTorch."""

import sys
from functools import partial
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

pytest.importorskip("stable_baselines3")

import torch
from stable_baselines3 import A2C, DQN, PPO, SAC, TD3
from stable_baselines3.common.policies import ActorCriticPolicy
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor
from stable_baselines3.common.vec_env import DummyVecEnv, VecNormalize
from stable_baselines3.sac.policies import Actor, SACPolicy
from torch import nn

from gym_extensions.baselines import sb3
from gym_extensions.baselines.adapters.sb3_policy import ACTIVATIONS, exported, policy_layers
from gym_extensions.baselines.adapters.sb3_vec_env import SpacesEnv
from gym_extensions.baselines.agent import Card, Context
from gym_extensions.baselines.record_policies import PolicyAgent
from gym_extensions.baselines.training.runner import Evaluator
from gym_extensions.catalog.groups import group
from gym_extensions.errors import BenchError
from gym_extensions.submissions.policies.mlp import Policy
from gym_extensions.submissions.policies.onnx import OnnxPolicy
from gym_extensions.verification.episodes import Cell, run_cell

OBSERVATIONS = gym.spaces.Box(-np.inf, np.inf, (5,), np.float64)
ACTIONS = gym.spaces.Box(np.array([-1, -3], np.float32), np.array([1, 5], np.float32))
IMAGES = gym.spaces.Box(0, 255, (36, 40, 3), np.uint8)
NETWORK: dict[str, Any] = {"net_arch": [8, 6]}


class Extractor(BaseFeaturesExtractor):
    """An own extractor of features, as wide as the observations."""

    def __init__(self, space: Any) -> None:
        super().__init__(space, space.shape[0])
        self.layers = nn.Sequential(nn.LayerNorm(space.shape[0]), nn.Linear(space.shape[0], space.shape[0]))

    def forward(self, observations: Any) -> Any:
        return self.layers(observations)


class Own(ActorCriticPolicy):
    """An own class of policies."""

    def __init__(self, *arguments: Any, **settings: Any) -> None:
        super().__init__(*arguments, **(settings | {"features_extractor_class": Extractor}))


class Bounded(ActorCriticPolicy):
    """An own class that bounds its mean action."""

    def _predict(self, observation: Any, deterministic: bool = False) -> Any:
        return torch.tanh(5 * super()._predict(observation, deterministic))


class Squared(ActorCriticPolicy):
    """An own class of which the network of the actor sees squares."""

    def extract_features(self, obs: Any, features_extractor: Any = None) -> Any:
        return super().extract_features(obs**2, features_extractor)


class Scaled(ActorCriticPolicy):
    """An own class of which the layer of the mean sees other values."""

    def _get_action_dist_from_latent(self, latent_pi: Any) -> Any:
        return super()._get_action_dist_from_latent(50 * latent_pi)


class BoundedActor(Actor):
    """An own actor of SAC."""

    def forward(self, obs: Any, deterministic: bool = False) -> Any:
        return 0.5 * super().forward(obs, deterministic)


class BoundedSac(SACPolicy):
    """With this actor."""

    def make_actor(self, features_extractor: Any = None) -> Actor:
        return BoundedActor(**self._update_features_extractor(self.actor_kwargs, features_extractor))


EXTRACTED: dict[str, Any] = {"policy_kwargs": {"features_extractor_class": Extractor}}
PLAIN: dict[str, tuple[Any, dict[str, Any]]] = {
    "PPO": (PPO, {}),
    "PPO, linear": (PPO, {"net_arch": []}),
    "SAC, linear": (SAC, {"net_arch": []}),
    "A2C with ELU": (A2C, {"activation_fn": nn.ELU}),
    "SAC": (SAC, {}),
    "TD3": (TD3, {"activation_fn": nn.LeakyReLU}),
}
NETWORKS: dict[str, tuple[Any, dict[str, Any], gym.spaces.Box]] = {
    "PPO, own extractor": (PPO, EXTRACTED, OBSERVATIONS),
    "PPO, own extractor, normalized": (PPO, EXTRACTED | {"normalize_observations": True}, OBSERVATIONS),
    "PPO, own class": (PPO, {"policy": Own}, OBSERVATIONS),
    "PPO, own actions": (PPO, {"policy": Bounded}, OBSERVATIONS),
    "PPO, own features": (PPO, {"policy": Squared}, OBSERVATIONS),
    "PPO, own distribution": (PPO, {"policy": Scaled}, OBSERVATIONS),
    "SAC, own actor": (SAC, {"policy": BoundedSac, "buffer_size": 10}, OBSERVATIONS),
    "SAC, own extractor": (SAC, EXTRACTED | {"buffer_size": 10}, OBSERVATIONS),
    "TD3, own extractor": (TD3, EXTRACTED | {"buffer_size": 10}, OBSERVATIONS),
    "PPO, images": (PPO, {"policy": "CnnPolicy"}, IMAGES),
}


def model(name: str) -> Any:
    """A model whose initial parameters are all different from 0."""
    torch.manual_seed(0)
    algorithm, network = PLAIN[name]
    created = algorithm("MlpPolicy", SpacesEnv(OBSERVATIONS, ACTIONS), policy_kwargs=NETWORK | network)
    with torch.no_grad():
        for values in created.policy.parameters():
            values.add_(0.1 * torch.randn(values.shape))
    return created


@pytest.mark.parametrize("name", PLAIN)
def test_the_policy_acts_as_the_model(name: str) -> None:
    trained = model(name)
    observations = np.random.default_rng(0).normal(size=(20, 5)).astype(np.float32)
    expected, _ = trained.predict(observations, deterministic=True)
    policy = exported(trained)
    assert isinstance(policy, Policy)
    actions = np.clip(policy.act(observations), ACTIONS.low, ACTIONS.high)
    np.testing.assert_allclose(actions, expected, rtol=1e-5, atol=1e-5)


def require_equal_distributions(policy: Any, expected: Any, observation: Any) -> None:
    actions = policy.act(np.tile(observation, (4000, 1)), np.random.default_rng(1))
    actions = np.clip(actions, ACTIONS.low, ACTIONS.high)
    np.testing.assert_allclose(actions.mean(axis=0), expected.mean(axis=0), atol=0.15)
    np.testing.assert_allclose(actions.std(axis=0), expected.std(axis=0), rtol=0.08)


@pytest.mark.parametrize("name", ["PPO", "SAC"])
def test_samples_have_the_model_s_distribution(name: str) -> None:
    trained, observation = model(name), np.random.default_rng(0).normal(size=5).astype(np.float32)
    expected, _ = trained.predict(np.tile(observation, (4000, 1)), deterministic=False)
    require_equal_distributions(exported(trained, deterministic=False), expected, observation)


@pytest.mark.parametrize("algorithm", [PPO, SAC])
def test_samples_of_a_network_have_the_model_s_distribution(algorithm: Any) -> None:
    pytest.importorskip("onnxruntime", reason="needs the extra onnx")
    agent: Any = sb3(algorithm, deterministic=False, **EXTRACTED)(OBSERVATIONS, ACTIONS, 0)
    torch.manual_seed(0)
    observation = np.random.default_rng(0).normal(size=5).astype(np.float32)
    require_equal_distributions(agent.policy(), agent.act(np.tile(observation, (4000, 1))), observation)


@pytest.mark.parametrize("case", NETWORKS)
def test_a_network_acts_as_the_model(case: str) -> None:
    pytest.importorskip("onnxruntime", reason="needs the extra onnx")
    algorithm, settings, space = NETWORKS[case]
    agent: Any = sb3(algorithm, **settings)(space, ACTIONS, 0)
    space.seed(0)
    observations = np.stack([space.sample() for _ in range(4)])
    policy = agent.policy()
    assert isinstance(policy, OnnxPolicy)
    actions = np.clip(policy.act(observations), ACTIONS.low, ACTIONS.high)
    np.testing.assert_allclose(actions, agent.act(observations), rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize("deterministic", [True, False])
def test_a_recurrent_policy_is_a_network_with_a_state_that_acts_as_the_model(deterministic: bool) -> None:
    pytest.importorskip("onnxruntime", reason="needs the extra onnx")
    algorithm: Any = pytest.importorskip("sb3_contrib").RecurrentPPO
    lstm: dict[str, Any] = {"lstm_hidden_size": 4, "n_lstm_layers": 2, "net_arch": [6]}
    make: Any = sb3(algorithm, deterministic=deterministic, policy_kwargs=lstm, batch_size=16)
    agent = make(OBSERVATIONS, ACTIONS, 0)
    policy, state, rng, same = agent.policy(), None, np.random.default_rng(0), np.random.default_rng(0)
    sigma = 0 if deterministic else np.exp(agent._model.policy.log_std.detach().numpy())
    for seen in np.random.default_rng(1).normal(size=(5, 3, 5)).astype(np.float32):
        actions = policy.act(seen, rng)
        mean, state = agent._model.predict(seen, state, np.zeros(3, bool), deterministic=True)
        expected = mean + sigma * same.standard_normal(mean.shape, np.float32)
        np.testing.assert_allclose(actions, expected, atol=1e-5)  # the means lie inside the box


def test_the_statistics_of_the_observations_belong_to_the_policy() -> None:
    make = sb3(PPO, normalize_observations=True, policy_kwargs=NETWORK, n_steps=16, batch_size=16)
    agent: Any = make(OBSERVATIONS, ACTIONS, 0)
    statistics = agent._normalizer.obs_rms
    statistics.mean, statistics.var = np.arange(5.0), np.arange(1.0, 6.0)
    observations = np.random.default_rng(0).normal(scale=30, size=(20, 5))
    actions = np.clip(agent.policy().act(observations), ACTIONS.low, ACTIONS.high)
    np.testing.assert_allclose(actions, agent.act(observations), rtol=1e-5, atol=1e-5)


def test_a_model_that_was_loaded_with_normalized_observations_acts_on_them() -> None:
    trained = model("PPO")
    normalizer = VecNormalize(DummyVecEnv([partial(SpacesEnv, OBSERVATIONS, ACTIONS)]))
    moments: Any = normalizer.obs_rms
    moments.mean, moments.var = np.arange(5.0), np.arange(1.0, 6.0)
    trained.set_env(normalizer)
    observations = np.random.default_rng(0).normal(scale=30, size=(20, 5))
    expected, _ = trained.predict(normalizer.normalize_obs(observations), deterministic=True)
    for policy in (exported(trained), exported(model("PPO"), normalizer=normalizer)):
        actions = np.clip(policy.act(observations), ACTIONS.low, ACTIONS.high)
        np.testing.assert_allclose(actions, expected, rtol=1e-5, atol=1e-5)
    card = Card("ppo", "PPO", "A checkpoint.", "deterministic")
    recorded = PolicyAgent(trained, card)
    recorded.begin(0)
    context = Context(np.ones(20, bool))
    np.testing.assert_allclose(recorded.act(observations, context), expected, rtol=1e-5, atol=1e-5)


def test_a_policy_that_cannot_be_expressed_trains_without_one_and_is_named_on_export() -> None:
    agent: Any = sb3(PPO, use_sde=True)(OBSERVATIONS, ACTIONS, 0)
    with pytest.warns(UserWarning, match="stays claimed"):
        assert agent.policy() is None
    with pytest.raises(BenchError, match="use_sde"):
        exported(agent._model)
    with pytest.raises(BenchError, match="DQNPolicy, does not have boxes of numbers as spaces"):
        exported(DQN("MlpPolicy", "CartPole-v1", buffer_size=1))
    for kind, name in ((Bounded, "_predict"), (Scaled, "_get_action_dist_from_latent")):
        own: Any = sb3(PPO, kind, deterministic=False)(OBSERVATIONS, ACTIONS, 0)
        with pytest.warns(UserWarning, match=f"{kind.__name__}, overrides {name}, which a network cannot"):
            assert own.policy() is None


@pytest.mark.parametrize("settings", [EXTRACTED, {"policy_kwargs": {"activation_fn": nn.GELU}}])
def test_without_the_extra_a_network_is_not_stored_and_the_warning_says_what_to_install(
    settings: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "onnx", None)
    agent: Any = sb3(PPO, **settings)(OBSERVATIONS, ACTIONS, 0)
    with pytest.warns(UserWarning, match=r"gym-extensions\[onnx\]"):
        assert agent.policy() is None


@pytest.mark.parametrize("is_recurrent", [False, True])
def test_the_logged_episodes_are_those_that_a_verifier_repeats(is_recurrent: bool) -> None:
    algorithm: Any = PPO
    if is_recurrent:
        pytest.importorskip("onnxruntime", reason="needs the extra onnx")
        algorithm = pytest.importorskip("sb3_contrib").RecurrentPPO
    members = group("hopper-wall")
    evaluator = Evaluator(members)
    env = evaluator.envs(members.tasks[1])
    agent: Any = sb3(algorithm, batch_size=16)(env.single_observation_space, env.single_action_space, 0)
    logged = evaluator.evaluate(agent, 0, members.tasks[1], agent.policy())
    seeds = tuple(episode.seed for episode in logged)
    repeated = run_cell(members, agent.policy(), Cell(0, 1, seeds))
    assert [episode.return_ for episode in logged] == [outcome.return_ for outcome in repeated]
    evaluator.close()


@pytest.mark.parametrize("activation", ACTIVATIONS)
def test_every_activation_is_the_same_function(activation: type[nn.Module]) -> None:
    seen = 10 * np.random.default_rng(0).standard_normal((50, 5))
    network = nn.Sequential(nn.Linear(5, 16), activation(), nn.Linear(16, 2))
    policy = Policy(np.zeros(2, np.float32), np.ones(2, np.float32), **policy_layers(network))
    expected = network(torch.tensor(seen, dtype=torch.float32)).detach().numpy()
    np.testing.assert_allclose(policy.act(seen), expected, rtol=1e-5, atol=1e-5)


def test_a_layer_that_a_sequence_uses_twice_is_there_twice() -> None:
    tied, activation, seen = nn.Linear(2, 2), nn.Tanh(), np.ones((1, 2))
    network = nn.Sequential(tied, activation, tied, activation, nn.Linear(2, 2))
    policy = Policy(np.zeros(2), np.ones(2), **policy_layers(network))
    expected = network(torch.ones(1, 2)).detach().numpy()
    np.testing.assert_allclose(policy.act(seen), expected, rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize(
    ("modules", "message"),
    [
        ([nn.Linear(2, 2), nn.LayerNorm(2), nn.Linear(2, 2)], "LayerNorm cannot be part of a policy."),
        ([nn.Linear(2, 2), nn.ELU(2.0), nn.Linear(2, 2)], "ELU cannot be part of a policy."),
        ([nn.Linear(2, 2), nn.Linear(2, 2)], "Linear, Linear."),
        ([nn.Linear(2, 2), nn.Tanh(), nn.Linear(2, 2), nn.ReLU(), nn.Linear(2, 2)], "Tanh, Linear, ReLU"),
    ],
)
def test_other_networks_are_refused(modules: list[nn.Module], message: str) -> None:
    with pytest.raises(BenchError, match=message):
        policy_layers(*modules)
