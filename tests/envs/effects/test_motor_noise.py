"""Motor noise: its size, where it acts, and that it follows from seed and step."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats

from gym_extensions.envs.make import construct_mujoco

BODIES = ("Hopper", "Walker2d", "HalfCheetah", "Humanoid")


@pytest.mark.parametrize("body", BODIES)
def test_commands_get_noise_of_a_tenth_of_the_range_and_are_clipped(body: str) -> None:
    env = construct_mujoco(f"{body}MotorNoise")
    ranges = env.model.actuator_ctrlrange
    sigma = 0.1 * (ranges[:, 1] - ranges[:, 0])
    scaled: list[NDArray[np.float64]] = []
    for seed in range(100):
        env.reset(seed=seed)
        env.step(np.zeros(env.model.nu, np.float32))
        scaled.append(env.data.ctrl / sigma)
    drawn = np.ravel(scaled)
    assert stats.kstest(drawn, "norm").pvalue > 1e-3
    env.reset(seed=0)
    for _ in range(5):
        env.step(ranges[:, 1].astype(np.float32))
        assert (env.data.ctrl <= ranges[:, 1]).all()
        assert (env.data.ctrl > ranges[:, 0]).all()


def test_hoppers_cost_uses_the_command_and_humanoids_the_noisy_command() -> None:
    hopper, humanoid = construct_mujoco("HopperMotorNoise"), construct_mujoco("HumanoidMotorNoise")
    for env in (hopper, humanoid):
        env.reset(seed=0)
    assert hopper.step(np.full(3, 0.5, np.float32))[4]["reward_ctrl"] == pytest.approx(-1e-3 * 3 * 0.25)
    info = humanoid.step(np.full(17, 0.2, np.float32))[4]
    assert info["reward_ctrl"] == pytest.approx(-0.1 * np.square(humanoid.data.ctrl).sum())
    assert info["reward_ctrl"] != pytest.approx(-0.1 * 17 * 0.04)


def test_motor_noise_follows_from_the_reset_seed_and_the_step() -> None:
    first, second = construct_mujoco("HopperMotorNoise"), construct_mujoco("HopperMotorNoise")
    first.reset(seed=5)
    second.reset(seed=5)
    for action in np.random.default_rng(0).uniform(-0.2, 0.2, (30, 3)).astype(np.float32):
        first.step(action)
        second.step(-action)
        np.testing.assert_allclose(first.data.ctrl - action, second.data.ctrl + action, atol=1e-6)
