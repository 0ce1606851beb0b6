"""Goals that move during the episode."""

from __future__ import annotations

import numpy as np
import pytest

from gym_extensions.catalog.bodies import Rectangle
from gym_extensions.envs.effects.motors_and_goals import move
from gym_extensions.envs.make import construct_mujoco

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
