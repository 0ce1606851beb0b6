"""Makes the description of every task, from its model."""

import json
import math
from collections.abc import Iterable, Iterator
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.bodies import Body
from gym_extensions.catalog.descriptions import HINGE, SLIDE, Field, Joint, Link, Role, Row, Shape, Skeleton
from gym_extensions.catalog.tasks import MAPS, TASKS, Task
from gym_extensions.catalog.variations import WALL, RangeSensor, Wall
from gym_extensions.envs.mujoco.env import TaskEnv
from gym_extensions.envs.mujoco.model import base_spec, compile_model
from gym_extensions.envs.navigation.env import course
from gym_extensions.envs.navigation.geometry import CELL, HEIGHT, goals, load
from gym_extensions.envs.navigation.sensors import FIELDS
from gym_extensions.envs.range_beams import ANGLES, FANS, REACH

BEAM = "distance to the wall / 10 m, 0 without a hit"
CENTER = "about the center of mass"
FREE_POSITIONS = ("quaternion w", "quaternion x", "quaternion y", "quaternion z")
SIDE_VIEW = (90.0, 0.0)
"""Azimuth and elevation of a view along y, so that x points to the right."""
DIGITS = 4
GEOM = mujoco.mjtGeom


def observation_fields(task: Task) -> list[Field]:
    """Returns the entries of the task's observation, in order. A picture has none."""
    if task.body.family == "navigation":
        return list(FIELDS.get(course(task).family, ()))
    fields = LAYOUTS[task.body.family](compile_model(task), task.body)
    if any(isinstance(variation, RangeSensor) for variation in task.variations):
        beams = [f"range beam at {round(math.degrees(angle)):+d}°: {BEAM}" for angle in ANGLES]
        fields += [Field(beam, "10 m", 0, 1) for beam in beams]
    return fields


def action_fields(task: Task) -> list[Field]:
    """Returns the entries of the task's action, in order."""
    if task.body.family == "navigation":
        return [Field(f"displacement in {axis}, clipped to the range", "unit", -5.0, 5.0) for axis in "xy"]
    model = compile_model(task)
    fields = []
    for motor in range(model.nu):
        joint, gear = model.joint(model.actuator_trnid[motor, 0]).name, model.actuator_gear[motor, 0]
        fields.append(Field(f"motor of {joint}", f"{gear:g} N·m", *model.actuator_ctrlrange[motor].tolist()))
    return fields


def table(fields: Iterable[Field]) -> list[Row]:
    """Returns the row of each field, with its index, or its first and last index."""
    rows, first = [], 0
    for field in fields:
        last = first + field.count - 1
        index = str(first) if last == first else f"{first}–{last}"
        limits = f"{field.low:.6g} … {field.high:.6g}{', soft limit' if field.is_soft else ''}"
        is_bounded = math.isfinite(field.low) or math.isfinite(field.high)
        rows.append((index, field.meaning, field.unit, limits if is_bounded else "unbounded"))
        first = last + 1
    return rows


def _joint_field(model: mujoco.MjModel, joint: int) -> Field:
    low, high = model.jnt_range[joint] if model.jnt_limited[joint] else (-np.inf, np.inf)
    quantity, unit = ("angle", "rad") if model.jnt_type[joint] == HINGE else ("position", "m")
    return Field(f"{quantity} of {model.joint(joint).name}", unit, float(low), float(high), is_soft=True)


def _speed_field(model: mujoco.MjModel, joint: int, limit: float = math.inf) -> Field:
    unit = "rad/s" if model.jnt_type[joint] == HINGE else "m/s"
    return Field(f"velocity of {model.joint(joint).name}", unit, -limit, limit)


def _planar(model: mujoco.MjModel, body: Body) -> list[Field]:
    """Positions without x, then velocities."""
    limit = math.inf if body.velocity_limit is None else body.velocity_limit
    positions = [_joint_field(model, joint) for joint in range(1, model.njnt)]
    return positions + [_speed_field(model, joint, limit) for joint in range(model.njnt)]


def _humanoid(model: mujoco.MjModel, body: Body) -> list[Field]:
    """Positions without x and y, velocities, then the quantities of the bodies' dynamics."""
    joints = range(1, model.njnt)
    names = [model.body(index).name for index in range(1, model.nbody - model.nmocap)]
    return [
        Field("height of the torso", "m"),
        *(Field(f"attitude of the torso, {entry}", "1") for entry in FREE_POSITIONS),
        *(_joint_field(model, joint) for joint in joints),
        *(Field(f"velocity of the torso, {axis}", "m/s") for axis in "xyz"),
        *(Field(f"angular velocity of the torso, {axis}", "rad/s") for axis in "xyz"),
        *(_speed_field(model, joint) for joint in joints),
        *(Field(f"inertia and mass of {name} {CENTER}", "kg·m², kg·m, kg", count=10) for name in names),
        *(Field(f"angular, then linear velocity of {name}", "rad/s, m/s", count=6) for name in names),
        *(Field(f"torque of the motor of {model.joint(joint).name}", "N·m") for joint in joints),
        *(Field(f"contact torque, then force on {name}", "N·m, N", count=6) for name in names),
    ]


def _arm(model: mujoco.MjModel, body: Body) -> list[Field]:
    points = ("tip of the arm", "ball" if body.name == "Striker" else "object", "goal")
    return [
        *(_joint_field(model, joint) for joint in range(7)),
        *(_speed_field(model, joint) for joint in range(7)),
        *(Field(f"{axis} of the {point}", "m") for point in points for axis in "xyz"),
    ]


LAYOUTS = {"planar": _planar, "humanoid": _humanoid, "arm": _arm}
"""The layout of the observation of each family of MuJoCo bodies."""


def differences(task: Task) -> list[str]:
    """Returns one sentence per variation of a task."""
    if task.body.family == "navigation":
        found = course(task)
        x, y = goals()[found.map, found.goal]
        return [f"Map {found.map}, goal {found.goal} at ({x:g}, {y:g})."]
    return [variation.describe(task.body, base_spec(task.body)) for variation in task.variations]


def skeleton(task: Task) -> Skeleton:
    """Returns the skeleton of a MuJoCo task.

    The x and y of a mocap body are coordinates after those of ``qpos``.
    """
    model = compile_model(task)
    camera = task.body.camera if task.body.family == "arm" else None
    view = (camera.azimuth, camera.elevation) if camera else SIDE_VIEW
    links = [_link(task, model, index) for index in range(1, model.nbody)]
    links[0] = links[0]._replace(shapes=(*links[0].shapes, *_beams(task, model)))
    return Skeleton(view, tuple(links))


def _beams(task: Task, model: Any) -> Iterator[Shape]:
    """The range beams, at full length, in the frame of the torso."""
    if not any(isinstance(each, RangeSensor) for each in task.variations):
        return
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    origin, directions = FANS[task.body.beams](data.qpos, TaskEnv(task).template.root_lift)
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
        axes = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
        joints = tuple(Joint(SLIDE, model.nq + i, axes[i], (0.0, 0.0, 0.0), position[i]) for i in (0, 1))
    parent = int(model.body_parentid[index]) - 1
    w, x, y, z = _vector(model.body_quat[index])
    return Link(parent, position, (w, x, y, z), joints, tuple(_shapes(task, model, index, is_mocap)))


def _joint(model: Any, number: int) -> Joint:
    kind, coordinate = int(model.jnt_type[number]), int(model.jnt_qposadr[number])
    rest = round(float(model.qpos0[coordinate]) if kind in (SLIDE, HINGE) else 0.0, DIGITS)
    return Joint(kind, coordinate, _vector(model.jnt_axis[number]), _vector(model.jnt_pos[number]), rest)


def _shapes(task: Task, model: Any, index: int, is_mocap: bool) -> Iterator[Shape]:
    changed = [name for each in task.variations for name in each.geoms(task.body)]
    for geom in np.flatnonzero(model.geom_bodyid == index):
        name, kind = model.geom(geom).name, GEOM(int(model.geom_type[geom]))
        center, size = model.geom_pos[geom], model.geom_size[geom]
        if name == WALL:
            if any(isinstance(each, Wall) and not each.parked for each in task.variations):
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
        body = model.body(index).name
        role: Role = "far" if "left" in name else "body"
        if name in changed:
            role = "changed"
        elif "goal" in body:
            role = "goal"
        elif "object" in body or "ball" in body:
            role = "object"
        yield Shape(role, round(float(radius), DIGITS), _vector(center - half), _vector(center + half))


def _vector(values: Any) -> Any:
    return tuple(round(float(value), DIGITS) + 0.0 for value in values)


def descriptions() -> str:
    """Returns the text of ``descriptions.json``: all tasks, and the tables, skeletons and maps they share."""
    tables, skeletons, tasks = dict[str, int](), dict[str, int](), []
    for task in TASKS.values():
        facts: dict[str, Any] = {
            "differences": differences(task),
            "actions": _index(tables, table(action_fields(task))),
            "observations": _index(tables, table(observation_fields(task))),
        }
        if task.body.family == "navigation":
            found = course(task)
            x, y = goals()[found.map, found.goal]
            facts |= {"map": found.map, "goal": [x, HEIGHT - y]}
        else:
            facts["skeleton"] = _index(skeletons, skeleton(task))
        tasks.append(f"{json.dumps(task.id)}: {_compact(facts)}")
    cells = [rectangles(load(number).cells[::-1]) for number in MAPS]
    maps = [_compact([[int(value * CELL) for value in row] for row in rows]) for rows in cells]
    parts = {"maps": maps, "skeletons": skeletons, "tables": tables}
    lines = [f'"{name}": [\n' + ",\n".join(rows) + "\n]" for name, rows in parts.items()]
    lines.append('"tasks": {\n' + ",\n".join(tasks) + "\n}")
    return "{\n" + ",\n".join(lines) + "\n}\n"


def _index(shared: dict[str, int], value: Any) -> int:
    """The index of a value among different ones in the order of their first use."""
    return shared.setdefault(_compact(value), len(shared))


def _compact(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False, separators=(",", ":"))


def rectangles(cells: NDArray[np.bool_]) -> list[tuple[int, int, int, int]]:
    """Returns rectangles (x, y, width, height) that cover the true cells, row 0 first, each cell once."""
    left, covered = cells.copy(), []
    for y, x in zip(*np.nonzero(cells), strict=True):
        if not left[y, x]:
            continue
        width = int(np.argmin(np.append(left[y, x:], False)))
        below = np.append(left[y:, x : x + width].all(axis=1), False)
        height = int(np.argmin(below))
        left[y : y + height, x : x + width] = False
        covered.append((int(x), int(y), width, height))
    return covered
