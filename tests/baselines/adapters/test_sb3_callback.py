"""Callbacks, TensorBoard and settings that the training loop owns."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("stable_baselines3")

from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback

from gym_extensions.baselines import sb3
from gym_extensions.baselines.adapters import sb3 as sb3_options
from gym_extensions.baselines.training.recorder import Recorder
from gym_extensions.envs import make_vec
from gym_extensions.errors import BenchError

SMALL: dict[str, Any] = {"n_steps": 50, "batch_size": 50, "n_epochs": 1, "policy_kwargs": {"net_arch": [8]}}


@pytest.fixture(scope="module")
def env() -> Any:
    return make_vec("Hopper", 2)


def learn(env: Any, **options: Any) -> None:
    make = sb3(PPO, **SMALL, **options)
    agent = make(env.single_observation_space, env.single_action_space, 4)
    agent.learn(Recorder(env, ["Hopper"], steps=200, batch_steps=100, seed=0), 200)


class Counter(BaseCallback):
    """Counts steps, rollouts and ended episodes."""

    def __init__(self) -> None:
        super().__init__()
        self.steps = self.rollouts = self.episodes = self.ends = 0

    def _on_step(self) -> bool:
        self.steps += self.training_env.num_envs
        self.episodes += sum("episode" in info for info in self.locals["infos"])
        return True

    def _on_rollout_end(self) -> None:
        self.rollouts += 1

    def _on_training_end(self) -> None:
        self.ends += 1


def test_callbacks_are_called_as_in_sb3(env: Any) -> None:
    first, second = Counter(), Counter()
    learn(env, callback=[first, second])
    assert (first.steps, first.rollouts, first.ends) == (200, 2, 1)
    assert first.episodes > 0
    assert second.steps == 200


def test_a_callback_that_returns_false_ends_the_stage(env: Any) -> None:
    calls = []

    def stop(local_variables: dict[str, Any], global_variables: dict[str, Any]) -> bool:
        calls.append(local_variables["n_steps"])
        return len(calls) < 10

    learn(env, callback=stop)
    assert len(calls) == 10


def test_tensorboard_logs_have_a_folder_per_run(env: Any, tmp_path: Path) -> None:
    pytest.importorskip("tensorboard")
    learn(env, tensorboard_log=tmp_path, log_interval=1)
    assert [path.name for path in tmp_path.iterdir()] == ["ppo-seed4_1"]
    (events,) = (tmp_path / "ppo-seed4_1").iterdir()
    assert b"rollout/ep_rew_mean" in events.read_bytes()


def test_tensorboard_that_is_not_installed_is_an_error_before_training(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(sb3_options, "find_spec", lambda name: None)
    with pytest.raises(BenchError, match="tensorboard"):
        sb3(PPO, tensorboard_log="logs")


def test_the_seed_cannot_be_set() -> None:
    with pytest.raises(BenchError, match="'seed'"):
        sb3(PPO, seed=1)
