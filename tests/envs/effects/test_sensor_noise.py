"""Sensor noise: the delay, dropout and noise of the range beams."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from gym_extensions.envs import SensorNoise, customize
from gym_extensions.envs.effects.wall_and_sensor import beam_noise, disturb
from gym_extensions.envs.make import construct_mujoco

BODIES = ("Hopper", "Walker2d", "HalfCheetah", "Humanoid")


@pytest.mark.parametrize("body", BODIES)
def test_readings_are_those_of_the_previous_step_plus_noise(body: str) -> None:
    clear, noisy = construct_mujoco(f"{body}Wall"), construct_mujoco(f"{body}NoisyWall")
    reading, shown = (env.reset(seed=2)[0][-10:] for env in (clear, noisy))
    # The seed of the noise is drawn last.
    working, shift = beam_noise(int(clear.np_random.integers(2**32)), 1000, 0.05, 0.02)
    np.testing.assert_array_equal(shown, disturb(reading, working[0], shift[0]))
    space = clear.action_space
    for step in range(1, 40):
        action = np.random.default_rng(step).uniform(space.low, space.high, space.shape).astype(np.float32)
        latched, reading = reading, clear.step(action)[0][-10:]
        shown = noisy.step(action)[0][-10:]
        np.testing.assert_array_equal(shown, disturb(latched, working[step], shift[step]))
    np.testing.assert_array_equal(noisy.data.qpos, clear.data.qpos)


def test_the_first_reading_is_current_and_later_ones_are_one_step_late() -> None:
    quiet = [SensorNoise(dropout=1e-12, noise=1e-12)]
    late, clear = construct_mujoco(customize("HalfCheetahWall", quiet)), construct_mujoco("HalfCheetahWall")
    now, shown = clear.reset(seed=2)[0][-10:], late.reset(seed=2)[0][-10:]
    np.testing.assert_allclose(shown, now, atol=1e-10)
    for action in np.random.default_rng(0).uniform(-1, 1, (40, 6)).astype(np.float32):
        before, now = now, clear.step(action)[0][-10:]
        np.testing.assert_allclose(late.step(action)[0][-10:], before, atol=1e-10)


def test_dropout_and_noise_have_the_published_size() -> None:
    working, shift = beam_noise(3, 1000, 0.05, 0.02)
    assert working.shape == shift.shape == (1001, 10)
    assert 1 - working.mean() == pytest.approx(0.05, abs=0.01)
    assert stats.kstest(shift.ravel() / 0.02, "norm").pvalue > 1e-3


@pytest.mark.parametrize(
    ("clean", "working", "shift", "shown"),
    [
        (0.3, True, 0.02, 0.32),
        (0.3, False, 0.02, 0.0),
        (0.0, True, 0.02, 0.0),  # a beam that misses gets no noise
        (0.01, True, -0.05, 0.0),
        (0.99, True, 0.05, 1.0),
    ],
)
def test_only_beams_that_hit_get_noise(clean: float, working: bool, shift: float, shown: float) -> None:
    noisy = disturb(np.array([clean]), np.array([working]), np.array([shift]))
    assert noisy[0] == pytest.approx(shown)
