"""Draws the pictures of docs/environments. MuJoCo renders bodies, and maps are drawn from above."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.bodies.body import Camera
from gym_extensions.catalog.navigation_tasks import GOALS, MAPS
from gym_extensions.catalog.registry import TASKS
from gym_extensions.catalog.task import Task
from gym_extensions.catalog.variations.morphology import LimbScale
from gym_extensions.catalog.variations.obstacles import SensorNoise, Wall
from gym_extensions.envs.make import construct_mujoco
from gym_extensions.errors import BenchError

WIDTH, HEIGHT = 240, 200
LINE_RADIUS = 0.01
"""Radius of a line in the scene, m."""
Color = tuple[float, float, float, float]
Line = tuple[NDArray[np.float64], NDArray[np.float64], Color]
"""Start, end and color (red, green, blue, alpha) of a line in the scene."""
MAP_PIXEL = 2.0
"""Units per pixel of a map's picture."""

WALL_CAMERA = Camera(1.4, 0.5, 5.0, 100, -12)
"""The camera of tasks with a wall, which needs more room."""


def pictured(task: Task) -> bool:
    """Returns whether a task has a picture, because it is its base body or looks different from it."""
    if task.body.camera is None:
        return False
    kinds = {type(variation) for variation in task.variations}
    standing = any(isinstance(variation, Wall) and not variation.parked for variation in task.variations)
    return not kinds or LimbScale in kinds or (standing and SensorNoise not in kinds)


def task_picture(task: Task) -> str:
    """Returns the file name of a task's picture."""
    return f"{task.name.lower()}.png"


def map_picture(number: int) -> str:
    """Returns the file name of a map's picture."""
    return f"map{number}.png"


def pictures() -> dict[str, bytes]:
    """Renders every picture and returns PNG files by name.

    Raises:
        BenchError: MuJoCo cannot render on this machine.
    """
    bodies = {task_picture(row): _png(_body(row)) for row in TASKS.values() if pictured(row)}
    return bodies | {map_picture(number): _png(_map(number)) for number in MAPS}


def _body(task: Task) -> NDArray[np.uint8]:
    env = construct_mujoco(task)
    model, data = env.model, env.data
    has_wall = any(isinstance(variation, Wall) for variation in task.variations)
    view = WALL_CAMERA if has_wall or task.body.camera is None else task.body.camera
    if view.after_reset:
        env.reset(seed=0)
    return render(model, data, view, (WIDTH, HEIGHT))


def render(
    model: Any, data: Any, view: Camera, size: tuple[int, int], lines: Sequence[Line] | None = None
) -> NDArray[np.uint8]:
    """Renders a frame (height, width, 3). With ``lines``, these are drawn into the scene, without shadows.

    Raises:
        BenchError: MuJoCo cannot render on this machine.
    """
    mujoco.mj_forward(model, data)
    camera = mujoco.MjvCamera()
    camera.type = mujoco.mjtCamera.mjCAMERA_FREE
    camera.lookat[:] = (view.x, 0.0, view.z)
    camera.distance, camera.azimuth, camera.elevation = view.distance, view.azimuth, view.elevation
    model.vis.global_.offwidth, model.vis.global_.offheight = size
    try:
        with mujoco.Renderer(model, size[1], size[0]) as renderer:
            renderer.update_scene(data, camera)
            if lines is not None:
                renderer.scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = 0
            for start, end, color in lines or ():
                _draw_line(renderer.scene, start, end, color)
            frame: NDArray[np.uint8] = renderer.render()
            return frame
    except (AttributeError, ImportError, RuntimeError, mujoco.FatalError) as failure:
        message = f"MuJoCo cannot render on this machine: {failure}."
        hint = "Set MUJOCO_GL=egl or MUJOCO_GL=osmesa and install that library."
        raise BenchError("no-rendering", message, hint=hint) from failure


def _draw_line(scene: Any, start: NDArray[np.float64], end: NDArray[np.float64], color: Color) -> None:
    geom = scene.geoms[scene.ngeom]
    kind = mujoco.mjtGeom.mjGEOM_CAPSULE
    mujoco.mjv_initGeom(geom, kind, np.zeros(3), np.zeros(3), np.zeros(9), np.array(color, np.float32))
    mujoco.mjv_connector(geom, kind, LINE_RADIUS, start, end)
    scene.ngeom += 1


def _map(number: int) -> NDArray[np.uint8]:
    from gym_extensions.envs.navigation.grid import arena
    from gym_extensions.envs.navigation.rendering import background

    frames = np.stack([background(arena(number, goal), MAP_PIXEL) for goal in GOALS])
    # Red is darker than free space in green and blue, so the minimum shows all three goals.
    darkest: NDArray[np.uint8] = frames.min(axis=0)
    return darkest


def _png(frame: NDArray[np.uint8]) -> bytes:
    from PIL import Image

    buffer = io.BytesIO()
    Image.fromarray(frame).quantize(64).save(buffer, "PNG", optimize=True)
    return buffer.getvalue()
