"""The shapes of a skeleton are where MuJoCo has them."""

from typing import Any

import mujoco
import numpy as np
import pytest

from gym_extensions.catalog.descriptions import descriptions
from gym_extensions.catalog.tasks import task
from gym_extensions.envs.mujoco.env import TaskEnv
from gym_extensions.envs.mujoco.model import compile_model
from gym_extensions.envs.range_beams import FANS
from gym_extensions.site.play.watch import placed

SIDE = (90.0, 0.0)


@pytest.mark.parametrize(
    "name",
    ["HopperWall", "Walker2dBigFoot", "HalfCheetah", "HumanoidSmallHand", "PusherMovingGoal", "Striker"],
)
def test_the_center_of_every_shape_is_that_of_its_geom(name: str) -> None:
    row = task(name)
    model, facts = compile_model(row), descriptions().get(row.id)
    data = mujoco.MjData(model)
    assert facts is not None and facts.skeleton is not None
    random = np.random.default_rng(0)
    coordinates = random.normal(0, 1, (2, model.nq + 2))
    everything = placed(facts.skeleton._replace(view=SIDE), coordinates)
    shapes = [shape for shape in everything if shape.role != "beam"]
    moving = [geom for geom in range(model.ngeom) if model.geom_bodyid[geom] > 0]
    geoms = [geom for geom in moving if not model.geom(geom).name.startswith("plate")]
    assert len(shapes) == len(geoms)
    for frame in range(2):
        data.qpos[:] = coordinates[frame, : model.nq]
        if model.nmocap:
            data.mocap_pos[0, :2] = coordinates[frame, model.nq :]
        mujoco.mj_kinematics(model, data)
        centers = [(shape.start[frame] + shape.end[frame]) / 2 for shape in shapes]
        np.testing.assert_allclose(centers, data.geom_xpos[geoms][:, [0, 2]], atol=1e-4)


@pytest.mark.parametrize("name", ["HopperWithSensor", "HumanoidWall", "HumanoidStandupWithSensor"])
def test_beams_are_those_of_the_sensor(name: str) -> None:
    env: Any = TaskEnv(task(name))
    env.reset(seed=0)
    facts = descriptions().get(task(name).id)
    assert facts is not None and facts.skeleton is not None
    coordinates = np.append(env.data.qpos, [2.0, 0.0])[None]
    shapes = placed(facts.skeleton._replace(view=SIDE), coordinates)
    beams = [shape for shape in shapes if shape.role.endswith("beam")]
    origin, directions = FANS[task(name).body.beams](env.data.qpos, env.template.root_lift)
    np.testing.assert_allclose([beam.start[0] for beam in beams], [origin[[0, 2]]] * 10, atol=2e-3)
    ends = origin + 10 * directions
    np.testing.assert_allclose([beam.end[0] for beam in beams], ends[:, [0, 2]], atol=2e-3)
