"""Draws the pictures of docs/environments. MuJoCo renders bodies, and maps are drawn from above."""

from __future__ import annotations

import io

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
    mujoco.mj_forward(model, data)
    camera = mujoco.MjvCamera()
    camera.type = mujoco.mjtCamera.mjCAMERA_FREE
    camera.lookat[:] = (view.x, 0.0, view.z)
    camera.distance, camera.azimuth, camera.elevation = view.distance, view.azimuth, view.elevation
    try:
        with mujoco.Renderer(model, HEIGHT, WIDTH) as renderer:
            renderer.update_scene(data, camera)
            frame: NDArray[np.uint8] = renderer.render()
            return frame
    except (AttributeError, ImportError, RuntimeError, mujoco.FatalError) as failure:
        message = f"MuJoCo cannot render on this machine: {failure}."
        hint = "Set MUJOCO_GL=egl or MUJOCO_GL=osmesa and install that library."
        raise BenchError("no-rendering", message, hint=hint) from failure


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
