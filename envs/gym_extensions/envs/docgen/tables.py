"""Tables of the entries of observations and actions."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

import mujoco
import numpy as np

from gym_extensions.catalog.bodies import Body
from gym_extensions.catalog.task import Task
from gym_extensions.catalog.variations.obstacles import RangeSensor
from gym_extensions.envs.effects.range_sensor import ANGLES
from gym_extensions.envs.fields import Field
from gym_extensions.envs.mujoco.compile import compile_model

FREE_POSITIONS = ("quaternion w", "quaternion x", "quaternion y", "quaternion z")
HINGE = int(mujoco.mjtJoint.mjJNT_HINGE)


def observation_fields(task: Task) -> list[Field]:
    """Returns the entries of the task's observation, in order. A picture has none."""
    if task.body.family == "navigation":
        return _navigation(task)
    fields = LAYOUTS[task.body.family](compile_model(task), task.body)
    if any(isinstance(variation, RangeSensor) for variation in task.variations):
        fields += [_beam(angle) for angle in ANGLES]
    return fields


def action_fields(task: Task) -> list[Field]:
    """Returns the entries of the task's action, in order."""
    if task.body.family == "navigation":
        return [Field(f"displacement in {axis}, clipped to the range", "unit", -5.0, 5.0) for axis in "xy"]
    model = compile_model(task)
    fields = []
    for motor in range(model.nu):
        joint = model.joint(model.actuator_trnid[motor, 0]).name
        gear = model.actuator_gear[motor, 0]
        low, high = model.actuator_ctrlrange[motor]
        fields.append(Field(f"motor of {joint}", f"{gear:g} N·m", float(low), float(high)))
    return fields


def indexed(fields: Iterable[Field]) -> list[tuple[str, Field]]:
    """Returns each field with its index, or its first and last index."""
    rows, first = [], 0
    for field in fields:
        last = first + field.count - 1
        rows.append((str(first) if last == first else f"{first}–{last}", field))
        first = last + 1
    return rows


def _joint_fields(model: mujoco.MjModel, joints: Iterable[int]) -> list[Field]:
    fields = []
    for joint in joints:
        name, hinge = model.joint(joint).name, model.jnt_type[joint] == HINGE
        low, high = model.jnt_range[joint] if model.jnt_limited[joint] else (-np.inf, np.inf)
        quantity, unit = ("angle", "rad") if hinge else ("position", "m")
        fields.append(Field(f"{quantity} of {name}", unit, float(low), float(high)))
    return fields


def _speed_fields(model: mujoco.MjModel, joints: Iterable[int], limit: float = math.inf) -> list[Field]:
    fields = []
    for joint in joints:
        unit = "rad/s" if model.jnt_type[joint] == HINGE else "m/s"
        fields.append(Field(f"velocity of {model.joint(joint).name}", unit, -limit, limit))
    return fields


def _planar(model: mujoco.MjModel, body: Body) -> list[Field]:
    """Positions without x, then velocities."""
    limit = math.inf if body.velocity_limit is None else body.velocity_limit
    return _joint_fields(model, range(1, model.njnt)) + _speed_fields(model, range(model.njnt), limit)


def _humanoid(model: mujoco.MjModel, body: Body) -> list[Field]:
    """Positions without x and y, velocities, then the quantities of the bodies' dynamics."""
    joints = range(1, model.njnt)
    names = [model.body(index).name for index in range(1, model.nbody - model.nmocap)]
    return [
        Field("height of the torso", "m"),
        *(Field(f"attitude of the torso, {entry}", "1") for entry in FREE_POSITIONS),
        *_joint_fields(model, joints),
        *(Field(f"velocity of the torso, {axis}", "m/s") for axis in "xyz"),
        *(Field(f"angular velocity of the torso, {axis}", "rad/s") for axis in "xyz"),
        *_speed_fields(model, joints),
        *(
            Field(f"inertia and mass of {name} about the center of mass", "kg·m², kg·m, kg", count=10)
            for name in names
        ),
        *(Field(f"angular, then linear velocity of {name}", "rad/s, m/s", count=6) for name in names),
        *(Field(f"torque of the motor of {model.joint(joint).name}", "N·m") for joint in joints),
        *(Field(f"contact torque, then force on {name}", "N·m, N", count=6) for name in names),
    ]


def _arm(model: mujoco.MjModel, body: Body) -> list[Field]:
    points = ("tip of the arm", "ball" if body.name == "Striker" else "object", "goal")
    return [
        *_joint_fields(model, range(7)),
        *_speed_fields(model, range(7)),
        *(Field(f"{axis} of the {point}", "m") for point in points for axis in "xyz"),
    ]


LAYOUTS: dict[str, Callable[[mujoco.MjModel, Body], list[Field]]] = {
    "planar": _planar,
    "humanoid": _humanoid,
    "arm": _arm,
}
"""The layout of the observation of each family of MuJoCo bodies."""


def _beam(angle: float) -> Field:
    degrees = round(math.degrees(angle))
    return Field(f"range beam at {degrees:+d}°: distance to the wall / 10 m, 0 without a hit", "10 m", 0, 1)


def _navigation(task: Task) -> list[Field]:
    from gym_extensions.envs.navigation.env import course
    from gym_extensions.envs.navigation.observations import FIELDS

    return list(FIELDS.get(course(task).family, ()))
