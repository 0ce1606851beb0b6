"""Motor noise, and goals that move during the episode."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats

from gym_extensions.catalog.bodies import Rectangle
from gym_extensions.envs.effects.motors_and_goals import move
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


BASES = {"PusherTrackingGoal": "PusherMovingGoal", "StrikerTrackingGoal": "Striker"}


@pytest.mark.parametrize(
    ("position", "velocity", "expected"),
    [
        ([0.5, 0.5], [0.1, -0.1], ([0.6, 0.4], [0.1, -0.1])),
        ([0.95, 0.5], [0.1, 0.0], ([0.95, 0.5], [-0.1, 0.0])),  # 5 cm to the edge, 5 cm back
        ([0.02, 0.97], [-0.1, 0.1], ([0.08, 0.93], [0.1, -0.1])),
    ],
)
def test_a_moving_goal_is_reflected_at_its_box(
    position: list[float], velocity: list[float], expected: tuple[list[float], list[float]]
) -> None:
    moved = move(np.array(position), np.array(velocity), Rectangle((0.0, 0.0), (1.0, 1.0)), 1.0)
    np.testing.assert_allclose(moved[0], expected[0], atol=1e-12)
    np.testing.assert_allclose(moved[1], expected[1], atol=1e-12)


@pytest.mark.parametrize(
    ("name", "low", "high"),
    [
        ("PusherTrackingGoal", (0.35, -0.25), (0.75, -0.05)),
        ("StrikerTrackingGoal", (0.15, 0.1), (0.7, 1.0)),
    ],
)
def test_a_tracking_goal_moves_at_its_velocity_within_its_box(
    name: str, low: tuple[float, float], high: tuple[float, float]
) -> None:
    env, base = construct_mujoco(name), construct_mujoco(BASES[name])
    generator = np.random.default_rng(0)
    for seed in range(10):
        before = env.reset(seed=seed)[0][-3:-1]
        base.reset(seed=seed)
        speed = np.abs(base.np_random.uniform(-0.2, 0.2, 2))  # drawn after the body
        assert (speed <= 0.2).all()
        order = speed[::-1] if name.startswith("Pusher") else speed
        straight = 0
        for _ in range(100):
            after = env.step(generator.uniform(-2, 2, 7).astype(np.float32))[0][-3:-1]
            assert (after >= np.array(low) - 1e-9).all()
            assert (after <= np.array(high) + 1e-9).all()
            straight += np.allclose(np.abs(after - before), order * 0.05, atol=1e-12)
            before = after
        assert straight >= 90
    np.testing.assert_array_equal(env.data.qvel[9:], np.zeros(len(env.data.qvel) - 9))
