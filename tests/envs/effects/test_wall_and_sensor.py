"""The wall, the range sensor that sees it, and noise on that sensor."""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np
import pytest
from scipy import stats

from gym_extensions.catalog.variations import RangeSensor, Variation, Wall
from gym_extensions.envs import SensorNoise, customize, make, make_vec
from gym_extensions.envs.effects import wall_and_sensor as sensor
from gym_extensions.envs.effects.wall_and_sensor import beam_noise, disturb
from gym_extensions.envs.make import construct_mujoco
from gym_extensions.errors import BenchError

from ..resets import assert_uniform, states_after_reset

BODIES = ("Hopper", "Walker2d", "HalfCheetah", "Humanoid")
SIZES = {"Hopper": 21, "Walker2d": 27, "HalfCheetah": 27, "Humanoid": 358}
WALLS = [f"{body}Wall" for body in (*BODIES, "HumanoidStandupAndRun")]


@pytest.mark.parametrize("name", WALLS)
def test_the_wall_is_the_box_of_the_specification(name: str) -> None:
    env = construct_mujoco(name)
    env.reset(seed=3)
    wall = env.model.geom("wall")
    x = env.data.mocap_pos[0, 0]
    width = 10.0 if name.startswith("Humanoid") else 0.8
    place = env.data.geom_xpos[wall.id]
    low, high = place - wall.size, place + wall.size
    np.testing.assert_allclose(low, [x - 0.2, -width / 2, -0.125], atol=1e-12)
    np.testing.assert_allclose(high, [x + 0.2, width / 2, 0.375], atol=1e-12)
    assert (wall.contype[0], wall.conaffinity[0], wall.condim[0], wall.priority[0]) == (1, 1, 1, 1)
    assert env.model.body("wall").id == env.model.nbody - 1
    assert env.model.body("wall").mass[0] == 0


@pytest.mark.parametrize("name", ["HopperWall", "HalfCheetahWall"])
def test_the_walls_x_is_uniform_over_2000_resets(name: str) -> None:
    places = states_after_reset(name, lambda env: env.data.mocap_pos[0].copy())
    assert_uniform(places[:, 0], 1.8, 3.8)
    assert (places[:, 1:] == [0, 0.125]).all()


@pytest.mark.parametrize("body", (*BODIES, "HumanoidStandup", "HumanoidStandupAndRun"))
def test_with_a_sensor_a_body_is_bit_for_bit_its_base_with_ten_zeros(body: str) -> None:
    base, sensing = construct_mujoco(body), construct_mujoco(f"{body}WithSensor")
    seen, expected = sensing.reset(seed=5)[0], base.reset(seed=5)[0]
    generator = np.random.default_rng(0)
    for _ in range(60):
        np.testing.assert_array_equal(seen, np.append(expected, np.zeros(10)))
        action = generator.uniform(base.action_space.low, base.action_space.high).astype(np.float32)
        seen, *rest, _ = sensing.step(action)
        expected, *others, _ = base.step(action)
        assert rest == others


@pytest.mark.parametrize("body", BODIES)
def test_with_a_wall_a_body_starts_and_moves_as_its_base_until_it_touches(body: str) -> None:
    base, walled = construct_mujoco(body), construct_mujoco(f"{body}Wall")
    expected, seen = base.reset(seed=5)[0], walled.reset(seed=5)[0]
    assert seen.shape == (SIZES[body],) == walled.observation_space.shape
    for _ in range(5):
        np.testing.assert_array_equal(seen[:-10], expected)
        action = np.zeros(base.action_space.shape, np.float32)
        expected, *others, _ = base.step(action)
        seen, *rest, _ = walled.step(action)
        assert rest == others


@pytest.mark.parametrize("body", BODIES)
def test_a_body_at_the_wall_is_pushed_back_without_friction(body: str) -> None:
    env = construct_mujoco(f"{body}Wall")
    env.reset(seed=0)
    wall = env.model.geom("wall").id
    touching = []
    for centre in np.arange(1.8, 0.2, -0.005):
        env.data.mocap_pos[0, 0] = centre
        mujoco.mj_forward(env.model, env.data)
        touching = [contact for contact in env.data.contact if wall in contact.geom and contact.dist < -0.002]
        if touching:
            break
    assert touching
    assert {contact.dim for contact in touching} == {1}
    normals = np.array([contact.frame[:3] for contact in touching])
    assert np.abs(normals[:, 0]).max() > 0.5
    assert env.data.efc_force[[contact.efc_address for contact in touching]].max() > 0


def test_humanoids_observation_and_contact_cost_leave_the_wall_out() -> None:
    env: Any = construct_mujoco("HumanoidWall")
    env.reset(seed=0)
    for _ in range(40):
        seen, _, _, _, infos = env.step(np.zeros(17, np.float32))
    agent = env.data.cfrc_ext[:-1]
    assert -infos["reward_contact"] == pytest.approx(min(5e-7 * np.square(agent).sum(), 10))
    parts = (env.data.qpos[2:], env.data.qvel, env.data.cinert[1:-1], env.data.cvel[1:-1])
    forces = (env.data.qfrc_actuator[6:], env.data.cfrc_ext[1:-1])
    expected = np.concatenate([np.ravel(part) for part in (*parts, *forces)])
    np.testing.assert_array_equal(seen[:-10], expected)


@pytest.mark.parametrize(
    ("base", "variations", "code"),
    [
        ("Pusher", [RangeSensor()], "misplaced-variation"),
        ("HopperWall", [Wall()], "repeated-variation"),
        ("Hopper", [SensorNoise()], "missing-variation"),
    ],
)
def test_a_variation_that_does_not_fit_raises_an_error(
    base: str, variations: list[Variation], code: str
) -> None:
    for make_one in (make, lambda *args: make_vec(customize(*args), 2)):
        with pytest.raises(BenchError) as caught:
            make_one(base, variations)
        assert caught.value.code == code


@pytest.mark.parametrize("body", ["Hopper", "Walker2d", "HalfCheetah", "Humanoid"])
def test_readings_agree_with_mujocos_ray_and_frames_at_100_random_poses(body: str) -> None:
    env = construct_mujoco(f"{body}Wall")
    generator = np.random.default_rng(8)
    box = env.model.geom("wall")
    hits = 0
    for _ in range(100):
        env.reset(seed=int(generator.integers(2**31)))
        qpos = env.data.qpos.copy()
        qpos[0] += generator.uniform(-1, 2)
        if body == "Humanoid":
            qpos[2] = generator.uniform(0.2, 1.6)
            qpos[3:7] += generator.normal(0, 0.3, 4)
        else:
            qpos[1] += generator.uniform(-0.6, 0.1)
            qpos[2] = generator.uniform(-1, 1)
        env.set_state(qpos, env.data.qvel.copy())
        torso = env.data.body("torso")
        frame = torso.xmat.reshape(3, 3)
        seen = env._get_obs()[-10:]
        for beam, reading in enumerate(seen):
            angle = math.radians(-45 + 10 * beam)
            direction = math.cos(angle) * frame[:, 0] + math.sin(angle) * frame[:, 2]
            distance = mujoco.mju_rayGeom(
                env.data.mocap_pos[0], np.eye(3).ravel(), box.size, torso.xpos, direction, box.type[0], None
            )
            inside = (np.abs(torso.xpos - env.data.mocap_pos[0]) <= box.size).all()
            expected = 0.0 if distance < 0 or distance > 10 or inside else distance / 10
            assert reading == pytest.approx(expected, abs=1e-9)
            hits += expected > 0
    assert hits > 50


@pytest.mark.parametrize(
    ("origin", "direction", "reading"),
    [
        ((0.0, 0.0, 0.1), (1.0, 0.0, 0.0), 0.18),  # the face of a wall at x 2 lies at 1.8
        ((0.0, 0.0, -0.1), (1.0, 0.0, 0.0), 0.18),  # the part of the box below the floor counts
        ((0.0, 0.0, 0.4), (1.0, 0.0, 0.0), 0.0),  # over the top, which is at .375
        ((0.0, 0.5, 0.1), (1.0, 0.0, 0.0), 0.0),  # past the side, which is at .4
        ((3.0, 0.0, 0.1), (1.0, 0.0, 0.0), 0.0),  # behind
        ((2.0, 0.0, 0.1), (1.0, 0.0, 0.0), 0.0),  # inside
        ((2.0, 0.0, 1.375), (0.0, 0.0, -1.0), 0.1),  # from above on the top
        ((-8.2, 0.0, 0.1), (1.0, 0.0, 0.0), 1.0),  # exactly at the reach of 10 m
        ((-8.3, 0.0, 0.1), (1.0, 0.0, 0.0), 0.0),  # beyond it
    ],
)
def test_a_reading_is_the_distance_over_ten_metres(
    origin: tuple[float, ...], direction: tuple[float, ...], reading: float
) -> None:
    beams = np.tile(direction, (10, 1))
    half_sizes = np.array(Wall().half_sizes)
    readings = sensor.readings(np.array(origin), beams, np.array([2.0, 0.0, 0.125]), half_sizes)
    assert readings == pytest.approx(np.full(10, reading), abs=1e-12)


@pytest.mark.parametrize("name", ["HumanoidStandupAndRunWall"])
def test_lying_bodies_look_along_the_worlds_x_whatever_their_attitude(name: str) -> None:
    env = construct_mujoco(name)
    env.reset(seed=0)
    wall = env.data.mocap_pos[0, 0]
    for quaternion in ([1, 0, 0, 0], [0.5, 0.5, -0.5, 0.5], [0, 0, 0, 2]):
        qpos = env.init_qpos.copy()
        qpos[:3], qpos[3:7] = (0.0, 0.0, 0.105), quaternion
        env.set_state(qpos, np.zeros(env.model.nv))
        seen = env._get_obs()[-10:]
        # Beams 4 and 5 look 5° down and up: both meet the face.
        face = (wall - 0.2) / math.cos(math.radians(5)) / 10
        assert seen[5] == pytest.approx(face if (wall - 0.2) * math.tan(math.radians(5)) <= 0.27 else 0.0)


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
