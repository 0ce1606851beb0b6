"""Humanoid standing up and running: rewards recomputed from the simulation's state."""

from __future__ import annotations

import numpy as np
import pytest

from gym_extensions.envs import make
from gym_extensions.envs.make import construct_mujoco
from gym_extensions.envs.mujoco_env import TaskEnv


def center(env: TaskEnv) -> float:
    masses = env.model.body_mass
    return float(masses @ env.data.xipos[:, 0] / masses.sum())


def costs(env: TaskEnv) -> float:
    contact = min(0.5e-6 * float(np.square(env.data.cfrc_ext[:14]).sum()), 10)
    return 0.1 * float(np.square(env.data.ctrl).sum()) + contact


@pytest.mark.parametrize("suffix", ["", "WithSensor", "Wall"])
def test_the_reward_of_standing_up_and_running_has_speed_height_and_health(suffix: str) -> None:
    env = construct_mujoco(f"HumanoidStandupAndRun{suffix}")
    generator = np.random.default_rng(2)
    env.reset(seed=9)
    heights = []
    for step in range(120):
        if step == 60:  # stand it up
            qpos = env.data.qpos.copy()
            qpos[2] = 1.3
            env.set_state(qpos, env.data.qvel.copy())
        before = center(env)
        _, reward, terminated, truncated, _ = env.step(generator.uniform(-0.4, 0.4, 17).astype(np.float32))
        z = env.data.qpos[2]
        expected = 1.25 * (center(env) - before) / 0.015 + z / 0.003 - costs(env) + (5 if 1 < z < 2 else 1)
        assert reward == pytest.approx(expected, rel=1e-12)
        assert not terminated
        assert not truncated
        heights.append(z)
    assert max(heights[:60]) < 1 < heights[60]


def test_standing_up_and_running_moves_like_standing_up_and_observes_like_humanoid() -> None:
    run, up = make("HumanoidStandupAndRun"), make("HumanoidStandup")
    np.testing.assert_array_equal(run.reset(seed=3)[0], up.reset(seed=3)[0])
    action = np.full(17, 0.2, np.float32)
    for _ in range(20):
        np.testing.assert_array_equal(run.step(action)[0], up.step(action)[0])
    assert run.observation_space.shape == make("Humanoid").observation_space.shape == (348,)
