"""The entries of observations and actions: index, meaning, unit, range."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import mujoco
import numpy as np

from gym_extensions.catalog.task import Task
from gym_extensions.catalog.variations.obstacles import RangeSensor
from gym_extensions.envs.mujoco.compile import compile_model

SPEED_LIMITS = {"Hopper": 10.0, "Walker2d": 10.0}
"""Where Gymnasium clips the velocities it shows."""
FREE_POSITIONS = ("quaternion w", "quaternion x", "quaternion y", "quaternion z")
SLIDE, HINGE = int(mujoco.mjtJoint.mjJNT_SLIDE), int(mujoco.mjtJoint.mjJNT_HINGE)


@dataclass(frozen=True)
class Field:
    """``count`` neighbouring entries that mean the same and have the same range."""

    meaning: str
    unit: str
    low: float = -math.inf
    high: float = math.inf
    count: int = 1

    @property
    def range(self) -> str:
        """The range as text."""
        if math.isinf(self.low) and math.isinf(self.high):
            return "unbounded"
        return f"{self.low:.6g} … {self.high:.6g}"


def observation_fields(task: Task) -> list[Field]:
    """What each entry of the task's observation means, in order; none for pictures."""
    if task.base == "Navigation":
        return _navigation(task)
    model = compile_model(task)
    body = {"Pusher": _arm, "Striker": _arm}.get(task.base)
    if body is None:
        body = _humanoid if task.base.startswith("Humanoid") else _planar
    fields = body(model, task.base)
    if any(isinstance(variation, RangeSensor) for variation in task.variations):
        fields += [_beam(index) for index in range(10)]
    return fields


def action_fields(task: Task) -> list[Field]:
    """What each entry of the task's action means, in order."""
    if task.base == "Navigation":
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
    """Each field with its index, or its first and last."""
    rows, place = [], 0
    for field in fields:
        last = place + field.count - 1
        rows.append((str(place) if last == place else f"{place}–{last}", field))
        place = last + 1
    return rows


def _joint_fields(model: mujoco.MjModel, joints: Iterable[int]) -> list[Field]:
    fields = []
    for joint in joints:
        name, hinge = model.joint(joint).name, model.jnt_type[joint] == HINGE
        low, high = model.jnt_range[joint] if model.jnt_limited[joint] else (-np.inf, np.inf)
        what, unit = ("angle", "rad") if hinge else ("position", "m")
        fields.append(Field(f"{what} of {name}", unit, float(low), float(high)))
    return fields


def _speed_fields(model: mujoco.MjModel, joints: Iterable[int], limit: float = math.inf) -> list[Field]:
    fields = []
    for joint in joints:
        unit = "rad/s" if model.jnt_type[joint] == HINGE else "m/s"
        fields.append(Field(f"velocity of {model.joint(joint).name}", unit, -limit, limit))
    return fields


def _planar(model: mujoco.MjModel, base: str) -> list[Field]:
    """Everything but the x position."""
    limit = SPEED_LIMITS.get(base, math.inf)
    return _joint_fields(model, range(1, model.njnt)) + _speed_fields(model, range(model.njnt), limit)


def _humanoid(model: mujoco.MjModel, base: str) -> list[Field]:
    """Everything but the x and y position, then what Gymnasium adds of the bodies' dynamics."""
    joints = range(1, model.njnt)
    bodies = [model.body(index).name for index in range(1, model.nbody - model.nmocap)]
    return [
        Field("height of the torso", "m"),
        *(Field(f"attitude of the torso, {entry}", "1") for entry in FREE_POSITIONS),
        *_joint_fields(model, joints),
        *(Field(f"velocity of the torso, {axis}", "m/s") for axis in "xyz"),
        *(Field(f"angular velocity of the torso, {axis}", "rad/s") for axis in "xyz"),
        *_speed_fields(model, joints),
        *(
            Field(f"inertia and mass of {body} about the centre of mass", "kg·m², kg·m, kg", count=10)
            for body in bodies
        ),
        *(Field(f"angular, then linear velocity of {body}", "rad/s, m/s", count=6) for body in bodies),
        *(Field(f"torque of the motor of {model.joint(joint).name}", "N·m") for joint in joints),
        *(Field(f"contact torque, then force on {body}", "N·m, N", count=6) for body in bodies),
    ]


def _arm(model: mujoco.MjModel, base: str) -> list[Field]:
    places = ("tip of the arm", "ball" if base == "Striker" else "object", "goal")
    return [
        *_joint_fields(model, range(7)),
        *_speed_fields(model, range(7)),
        *(Field(f"{axis} of the {place}", "m") for place in places for axis in "xyz"),
    ]


def _beam(index: int) -> Field:
    return Field(
        f"range beam at {-45 + 10 * index:+d}°: distance to the wall / 10 m, 0 without a hit", "10 m", 0, 1
    )


def _navigation(task: Task) -> list[Field]:
    from gym_extensions.envs.navigation.env import course
    from gym_extensions.envs.navigation.observations import FIELDS

    rows = FIELDS.get(course(task).family, ())
    return [Field(row.meaning, row.unit, row.low, row.high, row.count) for row in rows]
