"""Stable-Baselines3's ``VecEnv`` over our vector environments."""

from typing import Any

import numpy as np
import pytest

pytest.importorskip("stable_baselines3")

from gym_extensions.baselines.adapters.sb3_vec_env import BatchVecEnv
from gym_extensions.baselines.training.environment import TrainingEnv
from gym_extensions.envs import make_vec


def test_an_environment_whose_episode_ended_is_reset_and_its_info_has_the_last_observation() -> None:
    env = BatchVecEnv(TrainingEnv(make_vec("Hopper", 3), ["Hopper"], steps=1000, batch_steps=100, seed=0))
    env.reset()
    for _ in range(200):
        step: Any = env.step(np.ones((3, 3), np.float32))
        observations, rewards, dones, infos = step
        if dones.any():
            break
    i = int(np.flatnonzero(dones)[0])
    assert rewards.dtype == np.float32
    assert not np.array_equal(infos[i]["terminal_observation"], observations[i])
    assert infos[i]["TimeLimit.truncated"] is False
    assert infos[i]["episode"]["l"] > 0
    assert 1.2 < observations[i][0] < 1.3, "a hopper starts 1.25 m above the ground"
