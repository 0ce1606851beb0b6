"""The skeleton of a task: links, joints and capsules, from which pages draw it without a simulator."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import mujoco
import numpy as np

from gym_extensions.catalog.sheets import HINGE, SLIDE, Joint, Link, Role, Shape, Skeleton
from gym_extensions.catalog.task import Task
from gym_extensions.catalog.variations.morphology import LimbScale
from gym_extensions.catalog.variations.obstacles import WALL, RangeSensor, Wall
from gym_extensions.envs.effects.range_sensor import REACH, fan_of
from gym_extensions.envs.make import construct_mujoco
from gym_extensions.envs.mujoco.compile import compile_model

SIDE_VIEW = (90.0, 0.0)
"""Along y, so that x points to the right."""
DIGITS = 4
GEOM = mujoco.mjtGeom


def skeleton(task: Task) -> Skeleton:
    """Returns the skeleton of a MuJoCo task.

    The x and y of a mocap body are coordinates after those of ``qpos``.
    """
    model = compile_model(task)
    camera = task.body.camera
    is_arm = task.body.family == "arm" and camera is not None
    view = (camera.azimuth, camera.elevation) if is_arm and camera else SIDE_VIEW
    links = [_link(task, model, index) for index in range(1, model.nbody)]
    links[0] = links[0]._replace(shapes=(*links[0].shapes, *_beams(task, model)))
    return Skeleton(view, tuple(links))


def _beams(task: Task, model: Any) -> Iterator[Shape]:
    """The range beams, at full length, in the frame of the torso."""
    if not any(isinstance(row, RangeSensor) for row in task.variations):
        return
    env: Any = construct_mujoco(task)
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    origin, directions = fan_of(task.body)(data.qpos, env.root_lift)
    role: Role = "world-beam" if task.body.beams == "world" else "beam"
    turn = np.eye(3) if role == "world-beam" else data.xmat[1].reshape(3, 3).T
    start = turn @ (origin - data.xpos[1])
    for direction in directions:
        yield Shape(role, 0.0, _vector(start), _vector(start + REACH * turn @ direction))


def _link(task: Task, model: Any, index: int) -> Link:
    is_mocap = model.body_mocapid[index] >= 0
    first, count = model.body_jntadr[index], model.body_jntnum[index]
    joints = tuple(_joint(model, number) for number in range(first, first + count))
    position = _vector(model.body_pos[index])
    if is_mocap:
        x, y, z = position
        origin = (0.0, 0.0, 0.0)
        joints = (
            Joint(SLIDE, model.nq, (1.0, 0.0, 0.0), origin, x),
            Joint(SLIDE, model.nq + 1, (0.0, 1.0, 0.0), origin, y),
        )
    parent = int(model.body_parentid[index]) - 1
    w, x, y, z = _vector(model.body_quat[index])
    return Link(parent, position, (w, x, y, z), joints, tuple(_shapes(task, model, index, is_mocap)))


def _joint(model: Any, number: int) -> Joint:
    kind, coordinate = int(model.jnt_type[number]), int(model.jnt_qposadr[number])
    rest = float(model.qpos0[coordinate]) if kind in (SLIDE, HINGE) else 0.0
    return Joint(
        kind, coordinate, _vector(model.jnt_axis[number]), _vector(model.jnt_pos[number]), round(rest, DIGITS)
    )


def _shapes(task: Task, model: Any, index: int, is_mocap: bool) -> Iterator[Shape]:
    changed = [
        name for row in task.variations if isinstance(row, LimbScale) for name in task.body.parts[row.part]
    ]
    for geom in np.flatnonzero(model.geom_bodyid == index):
        name, kind = model.geom(geom).name, GEOM(int(model.geom_type[geom]))
        center, size = model.geom_pos[geom], model.geom_size[geom]
        if name == WALL:
            if any(isinstance(row, Wall) and not row.parked for row in task.variations):
                yield Shape("wall", 0.0, _vector(center), _vector(size))
            continue
        if is_mocap and kind == GEOM.mjGEOM_BOX:
            continue  # the plates of Striker's cup, which turn with it
        axis = np.zeros(9)
        mujoco.mju_quat2Mat(axis, model.geom_quat[geom])
        columns = axis.reshape(3, 3).T
        half, radius = columns[2] * size[1], size[0]
        if kind == GEOM.mjGEOM_SPHERE:
            half = np.zeros(3)
        elif kind == GEOM.mjGEOM_BOX:
            longest = int(np.argmax(size))
            radius = float(np.median(size))
            half = columns[longest] * (size[longest] - radius)
        elif kind == GEOM.mjGEOM_CYLINDER:
            half = columns[2] * max(size[1] - radius, 0.0)
        yield Shape(
            _role(model, index, name, name in changed),
            round(float(radius), DIGITS),
            _vector(center - half),
            _vector(center + half),
        )


def _role(model: Any, index: int, name: str, is_changed: bool) -> Role:
    body = model.body(index).name
    if is_changed:
        return "changed"
    if "goal" in body:
        return "goal"
    if "object" in body or "ball" in body:
        return "object"
    return "far" if "left" in name else "body"


def _vector(values: Any) -> Any:
    return tuple(round(float(value), DIGITS) + 0.0 for value in values)
