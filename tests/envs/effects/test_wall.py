"""Walls: their box, position and contacts; everything else is the base body."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
import pytest

from gym_extensions.catalog.variations import RangeSensor, SensorNoise, Variation, Wall
from gym_extensions.envs import customize, make, make_vec
from gym_extensions.envs.make import construct_mujoco
from gym_extensions.errors import BenchError

from ..resets import assert_uniform, states_after_reset

BODIES = ("Hopper", "Walker2d", "HalfCheetah", "Humanoid")
SIZES = {"Hopper": 21, "Walker2d": 27, "HalfCheetah": 27, "Humanoid": 358}
WIDTHS = {"Hopper": 0.8, "Walker2d": 0.8, "HalfCheetah": 0.8, "Humanoid": 10.0}
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
def test_a_wall_changes_neither_mass_nor_extent_of_the_model(body: str) -> None:
    base, walled = construct_mujoco(body).model, construct_mujoco(f"{body}Wall").model
    assert walled.body_mass.sum() == base.body_mass.sum()
    assert walled.stat.extent == base.stat.extent
    np.testing.assert_array_equal(walled.stat.center, base.stat.center)
    assert walled.stat.meaninertia == base.stat.meaninertia


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
