"""What the beams of the range sensor read, and their noise."""

import math

import mujoco
import numpy as np
import pytest
from scipy import stats

from gym_extensions.catalog.tasks import task
from gym_extensions.catalog.variations import Wall
from gym_extensions.envs import range_beams
from gym_extensions.envs.mujoco.env import TaskEnv
from gym_extensions.envs.range_beams import beam_noise, disturb


@pytest.mark.parametrize("body", ["Hopper", "Walker2d", "HalfCheetah", "Humanoid"])
def test_readings_agree_with_mujocos_ray_and_frames_at_100_random_poses(body: str) -> None:
    env = TaskEnv(task(f"{body}Wall"))
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
    beams, center = np.tile(direction, (1, 10, 1)), np.array([[2.0, 0.0, 0.125]])
    half_sizes = np.array(Wall().half_sizes)
    with np.errstate(divide="ignore", invalid="ignore"):
        readings = range_beams.readings(np.array([origin]), beams, center, half_sizes)
    assert readings[0] == pytest.approx(np.full(10, reading), abs=1e-12)


def test_lying_bodies_look_along_the_worlds_x_whatever_their_attitude() -> None:
    env = TaskEnv(task("HumanoidStandupAndRunWall"))
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
