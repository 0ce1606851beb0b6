"""Bigger and smaller body parts: radius, mass and total mass, compared with values calculated by hand."""

import itertools

import numpy as np
import pytest

from gym_extensions.catalog.tasks import customize, task
from gym_extensions.catalog.variations import LimbScale
from gym_extensions.envs import Gravity, make
from gym_extensions.envs.mujoco.env import TaskEnv

from ...conftest import refused

# kg. Mass of a capsule: 1000·π·r²·(L + 4r/3), of a sphere: 1000·4/3·π·r³; HalfCheetah's are scaled to 14.
TOTAL = {"Hopper": 15.820013406, "Walker2d": 23.677136633, "HalfCheetah": 14.0, "Humanoid": 42.116030492}
# body, part: mass of the part, then radius of each of its geoms. Fingerprints pin the other parts.
PARTS = {
    ("Hopper", "Foot"): (5.315574770, {"foot_geom": 0.06}),
    ("Walker2d", "Thigh"): (8.115781022, {"thigh_geom": 0.05, "thigh_left_geom": 0.05}),
    ("HalfCheetah", "Leg"): (2.788284519, {"fshin": 0.046, "bshin": 0.046}),
    ("Humanoid", "Thigh"): (16.119695986, {"right_thigh1": 0.06, "left_thigh1": 0.06, "butt": 0.09}),
}
ROWS = [(*key, size, factor) for key in PARTS for size, factor in (("Small", 0.75), ("Big", 1.25))]


@pytest.mark.parametrize(("body", "part", "size", "factor"), ROWS)
def test_a_part_has_the_expected_radius_and_mass_and_all_else_is_unchanged(
    body: str, part: str, size: str, factor: float
) -> None:
    mass, radii = PARTS[body, part]
    base, model = TaskEnv(task(body)).model, TaskEnv(task(f"{body}{size}{part}")).model
    for geom in range(base.ngeom):
        name = base.geom(geom).name
        expected = base.geom_size[geom].copy()
        if name in radii:
            assert expected[0] == radii[name]
            expected[0] = radii[name] * factor
        np.testing.assert_array_equal(model.geom_size[geom], expected, err_msg=name)
    assert base.body_mass.sum() == pytest.approx(TOTAL[body], abs=1e-8)
    assert model.body_mass.sum() == pytest.approx(TOTAL[body] + (factor - 1) * mass, abs=1e-8)
    changed = {base.geom(name).bodyid[0] for name in radii}
    gained = sum(model.body_mass[index] - base.body_mass[index] for index in changed)
    assert gained == pytest.approx((factor - 1) * mass, abs=1e-8)
    others = [index for index in range(base.nbody) if index not in changed]
    np.testing.assert_allclose(model.body_mass[others], base.body_mass[others], rtol=0, atol=1e-15)
    kept = "geom_pos geom_quat body_pos body_quat jnt_axis jnt_pos jnt_range dof_armature dof_damping"
    for name in [*kept.split(), "actuator_gear", "actuator_ctrlrange", "geom_friction", "geom_contype"]:
        np.testing.assert_array_equal(getattr(model, name), getattr(base, name), err_msg=name)
    np.testing.assert_array_equal(model.opt.gravity, base.opt.gravity)


def test_inertia_is_that_of_the_new_shape_at_the_new_mass() -> None:
    radius, length, mass = 0.05 * 1.25, 0.4, 3.665191429 * 1.25
    ball = mass * (4 / 3 * radius) / (length + 4 / 3 * radius)
    rod = mass - ball
    across = rod * (3 * radius**2 + length**2) / 12
    across += ball * (2 * radius**2 / 5 + length**2 / 4 + 3 * length * radius / 8)
    along = rod * radius**2 / 2 + ball * 2 * radius**2 / 5
    inertia = TaskEnv(task("HopperBigTorso")).model.body("torso").inertia
    assert sorted(inertia) == pytest.approx(sorted([across, across, along]), rel=1e-8)


def test_variations_of_different_parts_compose_in_any_order() -> None:
    chosen = (Gravity(0.7), LimbScale("Foot", 1.2), LimbScale("Torso", 0.9))
    orders = itertools.permutations(chosen)
    models = [TaskEnv(customize("HalfCheetah", order)).model for order in orders]
    for model in models[1:]:
        np.testing.assert_array_equal(model.body_mass, models[0].body_mass)
        np.testing.assert_array_equal(model.body_inertia, models[0].body_inertia)
    assert models[0].opt.gravity[2] == pytest.approx(-9.81 * 0.7)
    total = 14 + 0.2 * 1.979916318 - 0.1 * 4.662761506
    assert models[0].body_mass.sum() == pytest.approx(total, abs=1e-8)


@pytest.mark.parametrize(
    ("body", "part", "code", "fact"),
    [
        ("HalfCheetah", "Fot", "unknown-part", "HalfCheetah: There is no part 'Fot'. Did you mean 'Foot'?"),
        ("Hopper", "Arm", "unknown-part", "Foot, Leg, Thigh, Torso"),
        ("Pusher", "Arm", "misplaced-variation", "It fits Hopper"),
    ],
)
def test_an_unknown_part_raises_an_error(body: str, part: str, code: str, fact: str) -> None:
    with refused(code, fact):
        make(body, [LimbScale(part, 1.1)])
