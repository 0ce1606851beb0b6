"""The MuJoCo tasks, as tables. The order of this module is the order of the registry."""

from __future__ import annotations

from gym_extensions.catalog.bodies import BODIES
from gym_extensions.catalog.task import Task
from gym_extensions.catalog.variations.actuation import MotorNoise
from gym_extensions.catalog.variations.base import Variation
from gym_extensions.catalog.variations.goals import MovingGoal, MovingStart, TrackingGoal
from gym_extensions.catalog.variations.gravity import Gravity
from gym_extensions.catalog.variations.morphology import LimbScale
from gym_extensions.catalog.variations.obstacles import RangeSensor, SensorNoise, Wall

PLANAR_BODIES = ("Hopper", "Walker2d", "HalfCheetah")
RUNNING_BODIES = (*PLANAR_BODIES, "Humanoid")
STANDING_UP_BODIES = ("HumanoidStandup", "HumanoidStandupAndRun")

GRAVITIES = {
    "GravityHalf": 0.5,
    "GravityThreeQuarters": 0.75,
    "GravityOneAndQuarter": 1.25,
    "GravityOneAndHalf": 1.5,
}
SIZES = {"Small": 0.75, "Big": 1.25}
LIMBS = ("Foot", "Leg", "Thigh", "Torso")
FURTHER_LIMBS = {"HalfCheetah": ("Head",), "Humanoid": ("Head", "Arm", "Hand")}
"""Parts beyond the four that every running body has. HalfCheetah's head is not in the paper's groups."""
WITHOUT_WALL = ("HumanoidStandup",)
"""Bodies with a wall width whose only published task has the wall parked."""


def _task(suffix: str, base: str, *variations: Variation) -> Task:
    return Task(f"{base}{suffix}", base, variations, max_steps=BODIES[base].max_steps)


def running() -> list[Task]:
    """The running bodies without variations."""
    return [_task("", body) for body in RUNNING_BODIES]


def gravity() -> list[Task]:
    """The running bodies at four gravities."""
    return [
        _task(suffix, body, Gravity(factor))
        for body in RUNNING_BODIES
        for suffix, factor in GRAVITIES.items()
    ]


def morphology() -> list[Task]:
    """The running bodies with one part bigger or smaller."""
    return [
        _task(f"{size}{part}", body, LimbScale(part, factor))
        for body in RUNNING_BODIES
        for part in (*LIMBS, *FURTHER_LIMBS.get(body, ()))
        for size, factor in SIZES.items()
    ]


def standing_up() -> list[Task]:
    """Humanoid standing up, and standing up to run."""
    return [_task("", body) for body in STANDING_UP_BODIES]


def walls() -> list[Task]:
    """The range sensor with the wall parked out of reach, and with the wall in the way."""
    tasks = []
    for body in BODIES.values():
        if body.wall_width is None:
            continue
        tasks.append(_task("WithSensor", body.name, RangeSensor(), Wall(body.wall_width, parked=True)))
        if body.name not in WITHOUT_WALL:
            tasks.append(_task("Wall", body.name, RangeSensor(), Wall(body.wall_width)))
    return tasks


def arms() -> list[Task]:
    """Pushing and striking, with fixed and with random positions."""
    return [
        _task("", "Striker"),
        _task("MovingStart", "Striker", MovingStart()),
        _task("", "Pusher"),
        _task("MovingGoal", "Pusher", MovingGoal()),
    ]


def extras() -> list[Task]:
    """Tasks with motor noise, noisy sensors or moving goals. The paper announced them for future releases."""
    walls_in_the_way = {row.base: row.variations for row in walls() if row.name.endswith("Wall")}
    return [
        *(_task("MotorNoise", body, MotorNoise()) for body in RUNNING_BODIES),
        *(_task("NoisyWall", body, *walls_in_the_way[body], SensorNoise()) for body in RUNNING_BODIES),
        _task("TrackingGoal", "Pusher", MovingGoal(), TrackingGoal()),
        _task("TrackingGoal", "Striker", TrackingGoal()),
    ]


def mujoco_tasks() -> list[Task]:
    """Every MuJoCo task. A body that no table above names has one task, without variations."""
    tasks = [*running(), *gravity(), *morphology(), *standing_up(), *walls(), *arms(), *extras()]
    bases = {row.base for row in tasks}
    return [
        *tasks,
        *(_task("", body.name) for body in BODIES.values() if body.asset and body.name not in bases),
    ]
