"""Motor and sensor noise: its size, where it acts, and that it follows from seed and step."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from gym_extensions.envs import MotorNoise, SensorNoise, make
from gym_extensions.envs.effects import motors
from gym_extensions.envs.effects import range_sensor as sensor
from gym_extensions.errors import BenchError

BODIES = ("Hopper", "Walker2d", "HalfCheetah", "Humanoid")


@pytest.mark.parametrize("body", BODIES)
def test_motors_get_the_command_plus_a_tenth_of_their_range_clipped(body: str) -> None:
    env = make(f"{body}MotorNoise").unwrapped
    ranges = env.model.actuator_ctrlrange
    sigma = 0.1 * (ranges[:, 1] - ranges[:, 0])
    applied = []
    for seed in range(100):
        env.reset(seed=seed)
        env.step(np.zeros(env.model.nu, np.float32))
        applied.append(env.data.ctrl / sigma)
    drawn = np.ravel(applied)
    assert stats.kstest(drawn, "norm").pvalue > 1e-3
    env.reset(seed=0)
    for _ in range(5):
        env.step(ranges[:, 1].astype(np.float32))
        assert (env.data.ctrl <= ranges[:, 1]).all()
        assert (env.data.ctrl > ranges[:, 0]).all()


def test_hopper_pays_for_the_command_and_humanoid_for_what_was_applied() -> None:
    hopper, humanoid = make("HopperMotorNoise").unwrapped, make("HumanoidMotorNoise").unwrapped
    for env in (hopper, humanoid):
        env.reset(seed=0)
    assert hopper.step(np.full(3, 0.5, np.float32))[4]["reward_ctrl"] == pytest.approx(-1e-3 * 3 * 0.25)
    info = humanoid.step(np.full(17, 0.2, np.float32))[4]
    assert info["reward_ctrl"] == pytest.approx(-0.1 * np.square(humanoid.data.ctrl).sum())
    assert info["reward_ctrl"] != pytest.approx(-0.1 * 17 * 0.04)


def test_motor_noise_follows_from_the_reset_seed_and_the_step() -> None:
    first, second = make("HopperMotorNoise").unwrapped, make("HopperMotorNoise").unwrapped
    first.reset(seed=5)
    second.reset(seed=5)
    for action in np.random.default_rng(0).uniform(-0.2, 0.2, (30, 3)).astype(np.float32):
        first.step(action)
        second.step(-action)
        np.testing.assert_allclose(first.data.ctrl - action, second.data.ctrl + action, atol=1e-6)


def test_a_task_with_motor_noise_starts_as_its_base() -> None:
    for body in BODIES:
        np.testing.assert_array_equal(make(f"{body}MotorNoise").reset(seed=3)[0], make(body).reset(seed=3)[0])


def test_an_episodes_noise_differs_from_the_next_and_from_step_to_step() -> None:
    one, other = motors.motor_noise(1, 1000, 3), motors.motor_noise(2, 1000, 3)
    assert len({row.tobytes() for row in (*one, *other)}) == 2000


@pytest.mark.parametrize("body", BODIES)
def test_noisy_beams_are_those_of_the_step_before_disturbed(body: str) -> None:
    clear, noisy = make(f"{body}Wall").unwrapped, make(f"{body}NoisyWall").unwrapped
    reading, shown = (env.reset(seed=2)[0][-10:] for env in (clear, noisy))
    kept, shift = sensor.beam_noise(int(noisy.save_state()["derived_sensor_seed"]), 1000, 0.05, 0.02)
    np.testing.assert_array_equal(shown, sensor.disturbed(reading, kept[0], shift[0]))
    space = clear.action_space
    for step in range(1, 40):
        action = np.random.default_rng(step).uniform(space.low, space.high).astype(np.float32)
        latched, reading = reading, clear.step(action)[0][-10:]
        shown = noisy.step(action)[0][-10:]
        np.testing.assert_array_equal(shown, sensor.disturbed(latched, kept[step], shift[step]))
    np.testing.assert_array_equal(noisy.save_state()["qpos"], clear.save_state()["qpos"])


def test_the_first_reading_is_the_present_one_and_later_ones_are_a_step_late() -> None:
    quiet = [SensorNoise(dropout=1e-12, noise=1e-12)]
    late, clear = make("HalfCheetahWall", quiet).unwrapped, make("HalfCheetahWall").unwrapped
    now, shown = clear.reset(seed=2)[0][-10:], late.reset(seed=2)[0][-10:]
    np.testing.assert_allclose(shown, now, atol=1e-10)
    for action in np.random.default_rng(0).uniform(-1, 1, (40, 6)).astype(np.float32):
        before, now = now, clear.step(action)[0][-10:]
        np.testing.assert_allclose(late.step(action)[0][-10:], before, atol=1e-10)


def test_a_beam_drops_out_once_in_twenty_and_carries_noise_of_two_hundredths() -> None:
    kept, shift = sensor.beam_noise(3, 1000, 0.05, 0.02)
    assert kept.shape == shift.shape == (1001, 10)
    assert 1 - kept.mean() == pytest.approx(0.05, abs=0.01)
    assert stats.kstest(shift.ravel() / 0.02, "norm").pvalue > 1e-3


@pytest.mark.parametrize(
    ("clean", "kept", "shift", "shown"),
    [
        (0.3, True, 0.02, 0.32),
        (0.3, False, 0.02, 0.0),
        (0.0, True, 0.02, 0.0),  # a beam that hits nothing carries no noise
        (0.01, True, -0.05, 0.0),
        (0.99, True, 0.05, 1.0),
    ],
)
def test_a_reading_is_disturbed_only_where_it_hits(
    clean: float, kept: bool, shift: float, shown: float
) -> None:
    found = sensor.disturbed(np.array([clean]), np.array([kept]), np.array([shift]))
    assert found[0] == pytest.approx(shown)


@pytest.mark.parametrize(
    ("make_one", "text"),
    [
        (lambda: MotorNoise(0), "MotorNoise's scale is 0. Give a finite number above 0."),
        (lambda: SensorNoise(dropout=1.5), "SensorNoise's dropout is 1.5. Give at most 1."),
        (
            lambda: SensorNoise(noise=float("nan")),
            "SensorNoise's noise is nan. Give a finite number above 0.",
        ),
    ],
)
def test_impossible_noise_is_refused(make_one, text: str) -> None:
    with pytest.raises(BenchError) as caught:
        make_one()
    assert str(caught.value) == text
