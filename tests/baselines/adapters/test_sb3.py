"""Stable-Baselines3 joins: its VecEnv over our batches, and its models as agents."""

from __future__ import annotations

import csv
import tomllib

import numpy as np
import pytest

torch = pytest.importorskip("torch")
stable_baselines3 = pytest.importorskip("stable_baselines3")

from gym_extensions.baselines.adapters.sb3 import BatchVecEnv, sb3  # noqa: E402
from gym_extensions.baselines.train import train  # noqa: E402
from gym_extensions.baselines.training.evaluation import evaluate  # noqa: E402
from gym_extensions.baselines.training.recorder import Recorder  # noqa: E402
from gym_extensions.envs import make_vec  # noqa: E402
from gym_extensions.errors import BenchError  # noqa: E402

SMALL = {"n_steps": 125, "batch_size": 25, "n_epochs": 2}


def test_an_ended_lane_starts_anew_and_its_last_observation_is_told():
    batch = make_vec("Hopper", 3)
    env = BatchVecEnv(Recorder(batch, ["Hopper"], steps=1000, batch_steps=100, seed=0))
    env.reset()
    for _ in range(200):
        seen, rewards, done, infos = env.step(np.ones((3, 3), np.float32))
        if done.any():
            break
    lane = int(np.flatnonzero(done)[0])
    assert rewards.dtype == np.float32
    assert not np.array_equal(infos[lane]["terminal_observation"], seen[lane])
    assert infos[lane]["TimeLimit.truncated"] is False
    assert 1.2 < seen[lane][0] < 1.3, "a hopper starts 1.25 m above the ground"


def test_ppo_learns_through_the_protocol_to_a_submission(tmp_path):
    make = sb3(stable_baselines3.PPO, **SMALL)
    train(make, "hopper-gravity", "single", "smoke", 0, out=tmp_path)
    found = tomllib.loads((tmp_path / "submission.toml").read_text())
    assert found["protocol"]["algorithm"] == "ppo"
    assert found["protocol"]["evaluation"] == "deterministic"
    assert found["hyperparameters"] == SMALL
    assert found["memory"]["stored_steps"] == 125
    with (tmp_path / "hopper-gravity/curves.csv").open() as file:
        last = max(int(row["step"]) for row in csv.DictReader(file))
    assert 900 < last <= 1000


def test_every_setting_of_a_model_is_in_the_manifest_and_others_are_not_mixed_in(tmp_path):
    def made(width: int):
        network = {"net_arch": [width], "activation_fn": torch.nn.ReLU}
        return sb3(
            stable_baselines3.PPO, **SMALL, policy_kwargs=network, learning_rate=lambda left: 3e-4 * left
        )

    train(made(8), "hopper-gravity", "single", "smoke", 0, out=tmp_path)
    found = tomllib.loads((tmp_path / "submission.toml").read_text())["hyperparameters"]
    assert found.keys() == {*SMALL, "policy_kwargs", "learning_rate"}
    assert found["policy_kwargs"] == "{'net_arch': [8], 'activation_fn': ReLU}"
    with pytest.raises(BenchError) as told:
        train(made(16), "hopper-gravity", "single", "smoke", 1, out=tmp_path)
    assert str(told.value) == (
        f"{tmp_path / 'submission.toml'}: hyperparameters.policy_kwargs is "
        "\"{'net_arch': [8], 'activation_fn': ReLU}\" in this submission and "
        "\"{'net_arch': [16], 'activation_fn': ReLU}\" in the run. "
        "A submission is one algorithm at one budget with one set of settings; choose another --out."
    )


def test_settings_are_told_as_they_were_given_whatever_the_model_writes_into_them():
    env = make_vec("Hopper", 1)
    network = {"net_arch": [8]}
    make = sb3(stable_baselines3.SAC, policy_kwargs=network, buffer_size=100)
    for _ in range(2):
        agent = make(env.single_observation_space, env.single_action_space, 3)
        assert agent.card().hyperparameters == {"policy_kwargs": "{'net_arch': [8]}", "buffer_size": 100}
    assert network == {"net_arch": [8]}


def learned(look: bool) -> list[float]:
    env, lanes = make_vec("Hopper", 1), make_vec("Hopper", 2)
    make = sb3(stable_baselines3.PPO, deterministic=False, **SMALL)
    agent = make(env.single_observation_space, env.single_action_space, 3)
    for _ in range(2):
        if look:
            evaluate(agent, lanes, [1, 2])
        agent.learn(Recorder(env, ["Hopper"], steps=250, batch_steps=250, seed=0), 250)
    return [float(values.detach().sum()) for values in agent._model.policy.parameters()]


def test_being_evaluated_changes_nothing_that_an_sb3_agent_learns():
    assert learned(look=True) == learned(look=False)
