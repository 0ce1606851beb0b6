"""The pictures of tasks, which MuJoCo renders, and of maps."""

import io
from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.bodies import Camera
from gym_extensions.catalog.descriptions import picture_file
from gym_extensions.catalog.tasks import GOALS, MAPS, TASKS, Task
from gym_extensions.catalog.variations import Wall
from gym_extensions.envs.effects import compiled_readings, variation_of
from gym_extensions.envs.mujoco.env import TaskEnv
from gym_extensions.envs.navigation.geometry import arena
from gym_extensions.envs.navigation.sensors import background
from gym_extensions.envs.range_beams import FANS, REACH
from gym_extensions.errors import BenchError

SIZE = (640, 480)
"""Width and height in pixels of the picture of a task."""
LINE_RADIUS = 0.01
"""Radius of a line in the scene, m."""
QUALITY = 70
FREE_BEAM = 2.5
"""Drawn length of a beam that hits nothing, m."""
TABLE = -0.318
"""Height at which areas on the table are drawn, m."""
PUSHER_GOAL = (0.45, -0.05)
"""Position that Pusher's goal area is relative to (x, y)."""
Color = tuple[float, float, float, float]
Line = tuple[NDArray[np.float64], NDArray[np.float64], Color]
"""Start, end and color (red, green, blue, alpha) of a line in the scene."""
FLOOR: Color = (0.62, 0.66, 0.64, 1.0)
CHANGED: Color = (0.80, 0.16, 0.12, 1.0)
BEAM: Color = (0.95, 0.65, 0.05, 0.9)
AREA: Color = (0.10, 0.55, 0.25, 1.0)
MAP_PIXEL = 2.0
"""Units per pixel of a map's picture."""

WALL_CAMERA = Camera(1.4, 0.5, 5.0, 100, -12)
"""The camera of tasks with a wall, which needs more room."""


def map_picture(number: int) -> str:
    """Returns the file name of a map's picture."""
    return f"map{number}.png"


def map_pictures() -> dict[str, bytes]:
    """Draws every map with its three goals and returns PNG files by name."""
    pictures = {}
    for number in MAPS:
        frames = np.stack([background(arena(number, goal), MAP_PIXEL) for goal in GOALS])
        # Red is darker than free space in green and blue, so the minimum shows all three goals.
        pictures[map_picture(number)] = _encoded(frames.min(axis=0), "PNG", colors=64, optimize=True)
    return pictures


def _render(model: Any, data: Any, view: Camera, lines: Sequence[Line]) -> NDArray[np.uint8]:
    """Renders a frame (height, width, 3) with lines in the scene, without shadows.

    Raises ``BenchError`` if MuJoCo cannot render on this machine.
    """
    mujoco.mj_forward(model, data)
    camera = mujoco.MjvCamera()
    camera.type = mujoco.mjtCamera.mjCAMERA_FREE
    camera.lookat[:] = (view.x, 0.0, view.z)
    camera.distance, camera.azimuth, camera.elevation = view.distance, view.azimuth, view.elevation
    model.vis.global_.offwidth, model.vis.global_.offheight = SIZE
    try:
        with mujoco.Renderer(model, SIZE[1], SIZE[0]) as renderer:
            renderer.update_scene(data, camera)
            renderer.scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = 0
            capsule, scene = mujoco.mjtGeom.mjGEOM_CAPSULE, renderer.scene
            for start, end, color in lines:
                geom, shape = scene.geoms[scene.ngeom], (np.zeros(3), np.zeros(3), np.zeros(9))
                mujoco.mjv_initGeom(geom, capsule, *shape, np.array(color, np.float32))
                mujoco.mjv_connector(geom, capsule, LINE_RADIUS, start, end)
                scene.ngeom += 1
            return renderer.render()
    except (AttributeError, ImportError, RuntimeError, mujoco.FatalError) as failure:
        message = f"MuJoCo cannot render on this machine: {failure}."
        hint = "Set MUJOCO_GL=egl or MUJOCO_GL=osmesa and install that library."
        raise BenchError("no-rendering", message, hint=hint) from failure


def task_pictures() -> dict[str, bytes]:
    """Renders every picture of a task and returns WebP files by name.

    Raises ``BenchError`` if MuJoCo cannot render on this machine.
    """
    shown: dict[str, Task] = {}
    for task in TASKS.values():
        if name := picture_file(task):
            shown.setdefault(name, task)
    frames = {name: _frame(task) for name, task in shown.items()}
    return {name: _encoded(frame, "WEBP", quality=QUALITY, method=6) for name, frame in frames.items()}


def _encoded(frame: NDArray[np.uint8], kind: str, colors: int = 0, **options: Any) -> bytes:
    from PIL import Image  # the pages need it only for pictures

    image, buffer = Image.fromarray(frame), io.BytesIO()
    (image.quantize(colors) if colors else image).save(buffer, kind, **options)
    return buffer.getvalue()


def _frame(task: Task) -> NDArray[np.uint8]:
    env = TaskEnv(task)
    _paint(task, env.model)
    has_wall = "wall" in _shown(task)
    view = WALL_CAMERA if has_wall or task.body.camera is None else task.body.camera
    if view.after_reset:
        env.reset(seed=0)
    return _render(env.model, env.data, view, [*_beams(task, env), *_goal_area(task)])


def _shown(task: Task) -> set[str]:
    """What the picture shows of the task's variations."""
    return {each.shows for each in task.variations}


def _paint(task: Task, model: Any) -> None:
    """Colors the parts that differ, and the floor plainly, so that lines are seen and files are small."""
    changed = {name for each in task.variations for name in each.geoms(task.body)}
    for geom in range(model.ngeom):
        is_floor = model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_PLANE
        if is_floor or model.geom(geom).name in changed:
            model.geom_matid[geom] = -1
            model.geom_rgba[geom] = FLOOR if is_floor else CHANGED


def _beams(task: Task, env: Any) -> list[Line]:
    if "beams" not in _shown(task):
        return []
    mujoco.mj_forward(env.model, env.data)
    origin, directions = FANS[task.body.beams](env.data.qpos, env.template.root_lift)
    half_sizes = np.array(variation_of(task, Wall).half_sizes)
    (readings,) = compiled_readings()(origin[None], directions[None], env.data.mocap_pos[:1], half_sizes)
    hits = readings * REACH
    to_floor = np.where(directions[:, 2] < 0, origin[2] / -np.minimum(directions[:, 2], -1e-9), np.inf)
    lengths = np.where(hits > 0, hits, np.minimum(FREE_BEAM, to_floor))
    return [
        (origin, origin + length * along, BEAM) for length, along in zip(lengths, directions, strict=True)
    ]


def _goal_area(task: Task) -> list[Line]:
    area = task.body.goal_area
    if area is None or "goal" not in _shown(task):
        return []
    low, high = area.low, area.high
    if task.base == "Pusher":  # slide offsets (y, x)
        low = (PUSHER_GOAL[0] + area.low[1], PUSHER_GOAL[1] + area.low[0])
        high = (PUSHER_GOAL[0] + area.high[1], PUSHER_GOAL[1] + area.high[0])
    corners = [(low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1])]
    points = [np.array([*corner, TABLE]) for corner in corners]
    return [(points[index], points[index - 1], AREA) for index in range(4)]
