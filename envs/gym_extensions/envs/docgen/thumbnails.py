"""The pictures of docs/environments: bodies rendered by MuJoCo, maps drawn from above."""

from __future__ import annotations

import io

import mujoco
import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.navigation_tasks import GOALS, MAPS
from gym_extensions.catalog.registry import TASKS
from gym_extensions.catalog.task import Task
from gym_extensions.catalog.variations.morphology import LimbScale
from gym_extensions.catalog.variations.obstacles import SensorNoise, Wall
from gym_extensions.envs.make import construct
from gym_extensions.envs.mujoco.task_env import TaskEnv
from gym_extensions.errors import BenchError

WIDTH, HEIGHT = 240, 200
MAP_PIXEL = 2.0
"""Units a pixel of a map's picture."""

# Looked-at x and z, distance (m), azimuth and elevation (degrees) of the camera; a wall needs more room.
VIEWS = {
    "Hopper": (0.0, 0.65, 2.6, 90, -8),
    "Walker2d": (0.0, 0.65, 2.6, 90, -8),
    "HalfCheetah": (0.0, 0.45, 2.8, 90, -8),
    "Humanoid": (0.0, 0.85, 3.0, 120, -8),
    "HumanoidStandup": (0.4, 0.2, 3.0, 110, -20),
    "HumanoidStandupAndRun": (0.4, 0.2, 3.0, 110, -20),
    "Pusher": (0.5, -0.3, 2.1, 135, -40),
    "Striker": (0.5, -0.2, 2.4, 135, -40),
}
ARMS = ("Pusher", "Striker")
"""Bodies shown after a seeded reset: in the model's rest pose object and goal lie in one place."""
WALL_VIEW = (1.4, 0.5, 5.0, 100, -12)


def pictured(task: Task) -> bool:
    """Whether a task looks different from its base, or is the base."""
    if task.base == "Navigation":
        return False
    kinds = {type(variation) for variation in task.variations}
    standing = any(isinstance(variation, Wall) and not variation.parked for variation in task.variations)
    return not kinds or LimbScale in kinds or (standing and SensorNoise not in kinds)


def task_picture(task: Task) -> str:
    """The file name of a body's picture."""
    return f"{task.name.lower()}.png"


def map_picture(number: int) -> str:
    """The file name of a map's picture."""
    return f"map{number}.png"


def pictures() -> dict[str, bytes]:
    """Every picture as PNG by its file name.

    Raises:
        BenchError: nothing here can render without a screen.
    """
    made = {task_picture(row): _png(_body(row)) for row in TASKS.values() if pictured(row)}
    return made | {map_picture(number): _png(_map(number)) for number in MAPS}


def _body(task: Task) -> NDArray[np.uint8]:
    env = construct(task).unwrapped
    assert isinstance(env, TaskEnv)
    model, data = env.model, env.data
    if task.base in ARMS:
        env.reset(seed=0)
    mujoco.mj_forward(model, data)
    walled = any(isinstance(variation, Wall) for variation in task.variations)
    x, z, distance, azimuth, elevation = WALL_VIEW if walled else VIEWS[task.base]
    camera = mujoco.MjvCamera()
    camera.type = mujoco.mjtCamera.mjCAMERA_FREE
    camera.lookat[:] = (x, 0.0, z)
    camera.distance, camera.azimuth, camera.elevation = distance, azimuth, elevation
    try:
        with mujoco.Renderer(model, HEIGHT, WIDTH) as renderer:
            renderer.update_scene(data, camera)
            frame: NDArray[np.uint8] = renderer.render()
            return frame
    except (AttributeError, ImportError, RuntimeError, mujoco.FatalError) as failure:
        message = f"MuJoCo cannot render here: {failure}."
        hint = "Set MUJOCO_GL=egl or MUJOCO_GL=osmesa and install that library."
        raise BenchError("no-rendering", message, hint=hint) from failure


def _map(number: int) -> NDArray[np.uint8]:
    from gym_extensions.envs.navigation.grid import arena
    from gym_extensions.envs.navigation.rendering import background

    frames = np.stack([background(arena(number, goal), MAP_PIXEL) for goal in GOALS])
    # Red is darker than free space in green and blue: the least of the frames shows all three goals.
    least: NDArray[np.uint8] = frames.min(axis=0)
    return least


def _png(frame: NDArray[np.uint8]) -> bytes:
    from PIL import Image

    buffer = io.BytesIO()
    Image.fromarray(frame).quantize(64).save(buffer, "PNG", optimize=True)
    return buffer.getvalue()
