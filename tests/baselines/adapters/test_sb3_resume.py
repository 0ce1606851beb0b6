"""A saved agent of Stable-Baselines3 continues with the same bytes."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("stable_baselines3")

from stable_baselines3 import PPO, SAC, TD3

from gym_extensions.baselines import sb3
from gym_extensions.baselines.training.recorder import Recorder
from gym_extensions.envs import make_vec
from gym_extensions.errors import BenchError

NETWORK = {"net_arch": [8]}
OFF_POLICY: dict[str, Any] = {
    "policy_kwargs": NETWORK,
    "learning_starts": 20,
    "buffer_size": 100,
    "batch_size": 8,
}
MODELS: dict[str, tuple[Any, dict[str, Any]]] = {
    "PPO": (PPO, {"policy_kwargs": NETWORK, "n_steps": 30, "batch_size": 20}),
    "SAC": (SAC, OFF_POLICY),
    "TD3": (TD3, OFF_POLICY),
}


@pytest.fixture(scope="module")
def env() -> Any:
    return make_vec("Hopper", 2)


def factory(name: str, **options: Any) -> Callable[..., Any]:
    model, settings = MODELS[name]
    return sb3(model, normalize_observations=True, normalize_rewards=True, **options, **settings)


def create(name: str, env: Any, seed: int = 3, **options: Any) -> Any:
    return factory(name, **options)(env.single_observation_space, env.single_action_space, seed)


def learn(agent: Any, env: Any, seed: int) -> None:
    agent.learn(Recorder(env, ["Hopper"], steps=60, batch_steps=60, seed=seed), 60)


def saved(agent: Any, path: Path) -> bytes:
    agent.save(path)
    return path.read_bytes()


@pytest.mark.parametrize("name", MODELS)
def test_a_loaded_agent_acts_and_learns_as_the_saved_one(name: str, env: Any, tmp_path: Path) -> None:
    agent = create(name, env, deterministic=False)
    learn(agent, env, 1)
    path = tmp_path / "agent.npz"
    state = saved(agent, path)
    loaded = create(name, env, seed=99, deterministic=False)
    loaded.load(path)
    assert saved(loaded, path) == state
    observations = np.random.default_rng(0).normal(size=(3, 11))
    assert np.array_equal(agent.act(observations), loaded.act(observations))
    np.random.seed(7)  # noqa: NPY002  (what other code draws changes nothing)
    learn(agent, env, 2)
    learn(loaded, env, 2)
    assert saved(loaded, path) == saved(agent, path) != state


def test_one_seed_gives_the_same_bytes_and_another_seed_others(env: Any, tmp_path: Path) -> None:
    files = []
    for seed in (5, 5, 6):
        agent = create("PPO", env, seed)
        learn(agent, env, 1)
        files.append(saved(agent, tmp_path / "agent.npz"))
    assert files[0] == files[1] != files[2]


def test_a_checkpoint_is_read_without_pickle(env: Any, tmp_path: Path) -> None:
    path = tmp_path / "agent.npz"
    create("SAC", env).save(path)
    with np.load(path, allow_pickle=False) as arrays:
        assert all(arrays[name].dtype != object for name in arrays.files)


def test_statistics_change_in_training_only_and_persist(env: Any) -> None:
    agent = create("PPO", env)
    learn(agent, env, 1)
    mean, _, limit = agent._normalization.observation_statistics()
    count = agent._normalization._wrapper.obs_rms.count
    agent.act(np.ones((4, 11)))
    assert np.array_equal(agent._normalization.observation_statistics()[0], mean)
    learn(agent, env, 2)
    assert limit == 10
    # 30 steps and the first reset of two environments
    assert agent._normalization._wrapper.obs_rms.count - count == 62 == round(count)


def test_rewards_are_scaled_for_the_model_and_not_in_the_training_curve(env: Any) -> None:
    curves = []
    for normalize in (False, True):
        model, settings = MODELS["PPO"]
        make = sb3(model, normalize_rewards=normalize, **settings | {"learning_rate": 0.0})
        agent: Any = make(env.single_observation_space, env.single_action_space, 3)
        recorder = Recorder(env, ["Hopper"], steps=120, batch_steps=60, seed=1)
        agent.learn(recorder, 120)
        curves.append(recorder.points)
    assert curves[0] == curves[1] != []


def test_other_settings_do_not_fit_a_checkpoint(env: Any, tmp_path: Path) -> None:
    path = tmp_path / "agent.npz"
    create("PPO", env).save(path)
    other: Any = sb3(PPO, n_steps=30, batch_size=20)(env.single_observation_space, env.single_action_space, 0)
    with pytest.raises(BenchError) as error:
        other.load(path)
    assert error.value.code == "bad-checkpoint"
    assert str(error.value).startswith(f"{path}: The checkpoint does not fit this PPO: Error(s) in loading")


def test_another_number_of_environments_after_training_is_an_error(env: Any) -> None:
    agent = create("PPO", env)
    learn(agent, env, 1)
    with pytest.raises(BenchError) as error:
        learn(agent, make_vec("Hopper", 3), 1)
    assert error.value.code == "other-environments"
