"""The large pictures of task pages: a part that differs is colored, beams and areas of goals are drawn."""

from __future__ import annotations

import io
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.bodies.body import Camera, Rectangle
from gym_extensions.catalog.pictures import large_picture
from gym_extensions.catalog.registry import TASKS
from gym_extensions.catalog.task import Task
from gym_extensions.catalog.variations.goals import MovingGoal, TrackingGoal
from gym_extensions.catalog.variations.morphology import LimbScale
from gym_extensions.catalog.variations.obstacles import RangeSensor, Wall
from gym_extensions.envs.docgen.thumbnails import WALL_CAMERA, Color, Line, render
from gym_extensions.envs.effects.range_sensor import fan_of, readings
from gym_extensions.envs.make import construct_mujoco

WIDTH, HEIGHT = 640, 480
QUALITY = 70
FLOOR: Color = (0.62, 0.66, 0.64, 1.0)
CHANGED: Color = (0.80, 0.16, 0.12, 1.0)
BEAM: Color = (0.95, 0.65, 0.05, 0.9)
AREA: Color = (0.10, 0.55, 0.25, 1.0)
FREE_BEAM = 2.5
"""Drawn length of a beam that hits nothing, m."""
TABLE = -0.318
"""Height at which areas on the table are drawn, m."""
PUSHER_GOAL = (0.45, -0.05)
"""Position that Pusher's goal area is relative to (x, y)."""


def large_pictures() -> dict[str, bytes]:
    """Renders every large picture and returns WebP files by name.

    Raises:
        BenchError: MuJoCo cannot render on this machine.
    """
    rows: dict[str, Task] = {}
    for row in TASKS.values():
        if name := large_picture(row):
            rows.setdefault(name, row)
    return {name: _webp(_frame(row)) for name, row in rows.items()}


def _frame(row: Task) -> NDArray[np.uint8]:
    env = construct_mujoco(row)
    _plain_floor(env.model)
    _color_changes(row, env.model)
    view = _camera(row)
    if view.after_reset:
        env.reset(seed=0)
    lines = [*_beams(row, env), *_goal_area(row)]
    return render(env.model, env.data, view, (WIDTH, HEIGHT), lines)


def _camera(row: Task) -> Camera:
    if any(isinstance(variation, Wall | RangeSensor) for variation in row.variations):
        return WALL_CAMERA
    return row.body.camera or WALL_CAMERA


def _plain_floor(model: Any) -> None:
    """Removes the texture and the reflection of the floor, so that lines are seen and files are small."""
    for geom in range(model.ngeom):
        if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_PLANE:
            model.geom_matid[geom] = -1
            model.geom_rgba[geom] = FLOOR


def _color_changes(row: Task, model: Any) -> None:
    for variation in row.variations:
        if isinstance(variation, LimbScale):
            for name in row.body.parts[variation.part]:
                geom = model.geom(name).id
                model.geom_matid[geom] = -1
                model.geom_rgba[geom] = CHANGED


def _beams(row: Task, env: Any) -> list[Line]:
    if not any(isinstance(variation, RangeSensor) for variation in row.variations):
        return []
    mujoco.mj_forward(env.model, env.data)
    origin, directions = fan_of(row.body)(env.data.qpos, env.root_lift)
    wall = next(variation for variation in row.variations if isinstance(variation, Wall))
    hits = readings(origin, directions, env.data.mocap_pos[0], np.array(wall.half_sizes)) * 10
    to_floor = np.where(directions[:, 2] < 0, origin[2] / -np.minimum(directions[:, 2], -1e-9), np.inf)
    lengths = np.where(hits > 0, hits, np.minimum(FREE_BEAM, to_floor))
    return [
        (origin, origin + length * along, BEAM) for length, along in zip(lengths, directions, strict=True)
    ]


def _goal_area(row: Task) -> list[Line]:
    if not any(isinstance(variation, MovingGoal | TrackingGoal) for variation in row.variations):
        return []
    area = row.body.goal_area or Rectangle((0.0, 0.0), (0.0, 0.0))
    low, high = area.low, area.high
    if row.base == "Pusher":  # slide offsets (y, x)
        low = (PUSHER_GOAL[0] + area.low[1], PUSHER_GOAL[1] + area.low[0])
        high = (PUSHER_GOAL[0] + area.high[1], PUSHER_GOAL[1] + area.high[0])
    corners = [(low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1])]
    points = [np.array([*corner, TABLE]) for corner in corners]
    return [(points[index], points[index - 1], AREA) for index in range(4)]


def _webp(frame: NDArray[np.uint8]) -> bytes:
    from PIL import Image

    buffer = io.BytesIO()
    Image.fromarray(frame).save(buffer, "WEBP", quality=QUALITY, method=6)
    return buffer.getvalue()
