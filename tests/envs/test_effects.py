"""The wall, noise on the motors and the sensor, and goals that move during the episode."""

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats

from gym_extensions.catalog.bodies import Body, Rectangle
from gym_extensions.catalog.tasks import task
from gym_extensions.envs import Variation, customize, make, make_vec
from gym_extensions.envs.effects import move
from gym_extensions.envs.mujoco.env import TaskEnv
from gym_extensions.envs.range_beams import beam_noise, disturb

from .resets import assert_uniform, states_after_reset

BODIES = ("Hopper", "Walker2d", "HalfCheetah", "Humanoid")
WALLS = [f"{body}Wall" for body in (*BODIES, "HumanoidStandupAndRun")]


@pytest.mark.parametrize("name", WALLS)
def test_the_wall_is_the_box_of_the_specification(name: str) -> None:
    env = TaskEnv(task(name))
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


@dataclass(frozen=True)
class Hurdle(Variation):
    """Adds a box without contacts, which a program can move: a variation of a user."""

    x: float

    def apply(self, body: Body, spec: Any) -> None:
        hurdle = spec.worldbody.add_body(name="hurdle", mocap=True, pos=(self.x, 0, 0.05))
        hurdle.add_geom(size=(0.05, 0, 0), mass=0, contype=0, conaffinity=0)


@pytest.mark.parametrize("name", ["HopperWall", "HumanoidWall", "StrikerMovingStart", "StrikerTrackingGoal"])
def test_walls_and_goals_leave_a_users_own_bodies_in_place(name: str) -> None:
    env, plain = make(name, [Hurdle(0.7)]).unwrapped, make(name).unwrapped
    vector: Any = make_vec(customize(name, [Hurdle(0.7)]), 2)
    assert np.array_equal(env.reset(seed=1)[0], plain.reset(seed=1)[0])
    assert np.array_equal(vector.reset(seed=1)[0][0], plain.reset(seed=1)[0])
    assert env.data.body("hurdle").xpos.tolist() == [0.7, 0, 0.05]  # type: ignore[attr-defined]
    places = [row[:, 0].tolist() for row in vector.states()["mocap_pos"]]
    assert all(0.7 in row and len(set(row)) == 2 for row in places)


@pytest.mark.parametrize("name", ["HopperWall", "HalfCheetahWall"])
def test_the_walls_x_is_uniform_over_2000_resets(name: str) -> None:
    places = states_after_reset(name, lambda env: env.data.mocap_pos[0].copy())
    assert_uniform(places[:, 0], 1.8, 3.8)
    assert (places[:, 1:] == [0, 0.125]).all()


@pytest.mark.parametrize(
    ("body", "suffix", "steps"),
    [
        *((body, "Wall", 5) for body in BODIES),
        *((body, "WithSensor", 60) for body in (*BODIES, "HumanoidStandup", "HumanoidStandupAndRun")),
    ],
)
def test_with_a_sensor_a_body_moves_as_its_base_bit_for_bit_until_it_touches_a_wall(
    body: str, suffix: str, steps: int
) -> None:
    base, sensing = TaskEnv(task(body)), TaskEnv(task(f"{body}{suffix}"))
    expected, seen = base.reset(seed=5)[0], sensing.reset(seed=5)[0]
    assert seen.shape == sensing.observation_space.shape
    generator = np.random.default_rng(0)
    for _ in range(steps):
        np.testing.assert_array_equal(seen[:-10], expected)
        assert suffix == "Wall" or not seen[-10:].any()
        action = generator.uniform(base.action_space.low, base.action_space.high).astype(np.float32)
        expected, *others, _ = base.step(action)
        seen, *rest, _ = sensing.step(action)
        assert rest == others


@pytest.mark.parametrize("body", BODIES)
def test_a_body_at_the_wall_is_pushed_back_without_friction(body: str) -> None:
    env = TaskEnv(task(f"{body}Wall"))
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
    env: Any = TaskEnv(task("HumanoidWall"))
    env.reset(seed=0)
    for _ in range(40):
        seen, _, _, _, infos = env.step(np.zeros(17, np.float32))
    agent = env.data.cfrc_ext[:-1]
    assert -infos["reward_contact"] == pytest.approx(min(5e-7 * np.square(agent).sum(), 10))
    parts = (env.data.qpos[2:], env.data.qvel, env.data.cinert[1:-1], env.data.cvel[1:-1])
    forces = (env.data.qfrc_actuator[6:], env.data.cfrc_ext[1:-1])
    expected = np.concatenate([np.ravel(part) for part in (*parts, *forces)])
    np.testing.assert_array_equal(seen[:-10], expected)


@pytest.mark.parametrize("body", BODIES)
def test_readings_are_those_of_the_previous_step_plus_noise(body: str) -> None:
    clear, noisy = TaskEnv(task(f"{body}Wall")), TaskEnv(task(f"{body}NoisyWall"))
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


@pytest.mark.parametrize("body", BODIES)
def test_commands_get_noise_of_a_tenth_of_the_range_and_are_clipped(body: str) -> None:
    env = TaskEnv(task(f"{body}MotorNoise"))
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
    hopper, humanoid = TaskEnv(task("HopperMotorNoise")), TaskEnv(task("HumanoidMotorNoise"))
    for env in (hopper, humanoid):
        env.reset(seed=0)
    assert hopper.step(np.full(3, 0.5, np.float32))[4]["reward_ctrl"] == pytest.approx(-1e-3 * 3 * 0.25)
    info = humanoid.step(np.full(17, 0.2, np.float32))[4]
    assert info["reward_ctrl"] == pytest.approx(-0.1 * np.square(humanoid.data.ctrl).sum())
    assert info["reward_ctrl"] != pytest.approx(-0.1 * 17 * 0.04)


def test_motor_noise_follows_from_the_reset_seed_and_the_step() -> None:
    first, second = TaskEnv(task("HopperMotorNoise")), TaskEnv(task("HopperMotorNoise"))
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
    [("PusherTrackingGoal", (0.35, -0.25), (0.75, -0.05)), ("StrikerTrackingGoal", (0.15, 0.1), (0.7, 1.0))],
)
def test_a_tracking_goal_moves_at_its_velocity_within_its_box(
    name: str, low: tuple[float, float], high: tuple[float, float]
) -> None:
    env, base = TaskEnv(task(name)), TaskEnv(task(BASES[name]))
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
