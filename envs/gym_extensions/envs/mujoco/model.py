"""Compiles a task's MuJoCo model from Gymnasium's asset, edited as an MjSpec by the task's variations."""

import contextlib
import math
import warnings
from collections.abc import Iterator
from pathlib import Path

import gymnasium
import mujoco

from gym_extensions.catalog import bodies, tasks
from gym_extensions.errors import BenchError

ASSETS = Path(gymnasium.__file__).parent / "envs" / "mujoco" / "assets"


def asset(body: bodies.Body) -> Path:
    """The file of a base body's model among Gymnasium's installed assets."""
    return ASSETS / body.asset


def base_spec(body: bodies.Body) -> mujoco.MjSpec:
    """The specification of a base body without variations."""
    with _quiet():
        spec = mujoco.MjSpec.from_file(str(asset(body)))
    if body.name == "Striker":
        rebuild_striker(spec)
    return spec


def compile_model(task: tasks.Task) -> mujoco.MjModel:
    """Compiles the task's model directly from the edited specification.

    Writing XML would round numbers. Without it, the model of a task without variations equals Gymnasium's in
    every array. Variations are applied in a fixed order, so their order in the task does not matter.

    Raises ``BenchError`` if MuJoCo refuses the model, for example because a mass is too small.
    """
    spec = base_spec(task.body)
    with _quiet():
        try:
            for variation in sorted(task.variations, key=lambda each: (each.is_last, repr(each))):
                variation.apply(task.body, spec)
            return spec.compile()
        except ValueError as error:
            message = f"MuJoCo does not compile the model: {str(error).splitlines()[0]}."
            hint = "Give other values to its variations."
            raise BenchError("bad-model", message, task.id, hint) from error


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Silences the deprecation warning of ``settotalmass``, which defines HalfCheetah's masses."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=".*settotalmass.*")
        yield


WHITE = (1.0, 1.0, 1.0, 1.0)


def rebuild_striker(spec: mujoco.MjSpec) -> None:
    """Edits the pusher's specification into Striker's, with a paddle, a ball on slides, and a cup as goal.

    Gym removed Striker-v0 in 2022. The numbers are those of its model file, except for the goal. Gym's goal
    is a cup of 40 kg on a free joint, which tumbles when hit off-center; ours is a mocap body, which nothing
    moves.
    """
    for motor in spec.actuators:
        motor.ctrlrange = (-3.0, 3.0)
    tips = spec.body("tips_arm")
    # The cross-bar is the first of the fork's three capsules, two prongs follow. A paddle replaces them.
    for geom in [*tips.geoms, *spec.body("r_wrist_roll_link").geoms[-2:]]:
        spec.delete(geom)
    shape = {"type": mujoco.mjtGeom.mjGEOM_BOX, "pos": (0.017, 0, 0), "size": (0.003, 0.12, 0.05)}
    tips.add_geom(name="paddle", contype=1, conaffinity=1, **shape)
    _ball(spec)
    _goal(spec)
    for geom in spec.geoms:
        geom.friction = (0, 0, 0)


def _ball(spec: mujoco.MjSpec) -> None:
    ball = spec.body("object")
    ball.pos = (0, 0, -0.270)
    for geom in ball.geoms:
        spec.delete(geom)
    shape = {"type": mujoco.mjtGeom.mjGEOM_SPHERE, "size": (0.05, 0, 0)}
    ball.add_geom(name="ball", contype=1, conaffinity=0, rgba=WHITE, **shape)
    for joint in ball.joints:
        joint.range = (-10.3, 10.3)
        joint.damping[0] = 0.5
        joint.armature = 0.1


def _goal(spec: mujoco.MjSpec) -> None:
    spec.delete(spec.body("goal"))
    goal = spec.worldbody.add_body(name="goal", mocap=True, pos=(0, 0, -0.323))
    shape = {"type": mujoco.mjtGeom.mjGEOM_CYLINDER, "size": (0.08, 0.001, 0)}
    goal.add_geom(name="coaster", mass=0, contype=0, conaffinity=0, rgba=(1, 0, 0, 1), **shape)
    # A cup of three plates that are turned about its axis, in rad: it opens towards −y.
    x, y, z = 0.0, 0.075, 0.04
    for index, turn in enumerate((0.0, 0.785, -0.785)):
        sin, cos = math.sin(turn), math.cos(turn)
        shape = {
            "type": mujoco.mjtGeom.mjGEOM_BOX,
            "size": (0.032, 0.001, 0.04),
            "pos": (cos * x - sin * y, sin * x + cos * y, z),
            "quat": (math.cos(turn / 2), 0, 0, math.sin(turn / 2)),
        }
        goal.add_geom(name=f"plate{index}", mass=0, contype=0, conaffinity=1, rgba=WHITE, **shape)
