"""The MuJoCo tasks, as tables."""

from __future__ import annotations

from gym_extensions.catalog.task import Task
from gym_extensions.catalog.variations.actuation import MotorNoise
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
"""Parts beyond the four that every running body has; HalfCheetah's is outside the paper's groups."""

WALL_WIDTHS = dict.fromkeys(PLANAR_BODIES, 0.8) | {"Humanoid": 10.0} | dict.fromkeys(STANDING_UP_BODIES, 10.0)
"""Width of the wall, m: humanoids would walk around a narrow one."""
ARM_STEPS = 100


def running() -> list[Task]:
    """The unvaried running bodies."""
    return [Task(body, body) for body in RUNNING_BODIES]


def gravity() -> list[Task]:
    """The running bodies at four gravities."""
    return [
        Task(f"{body}{suffix}", body, (Gravity(factor),))
        for body in RUNNING_BODIES
        for suffix, factor in GRAVITIES.items()
    ]


def morphology() -> list[Task]:
    """The running bodies with one part bigger or smaller."""
    return [
        Task(f"{body}{size}{part}", body, (LimbScale(part, factor),))
        for body in RUNNING_BODIES
        for part in (*LIMBS, *FURTHER_LIMBS.get(body, ()))
        for size, factor in SIZES.items()
    ]


def standing_up() -> list[Task]:
    """Humanoid standing up, and standing up to run."""
    return [Task(body, body) for body in STANDING_UP_BODIES]


def walls() -> list[Task]:
    """Range sensor alone, with the wall parked out of reach, and with the wall in the way."""
    tasks = []
    for body, width in WALL_WIDTHS.items():
        tasks.append(Task(f"{body}WithSensor", body, (RangeSensor(), Wall(width, parked=True))))
        if body != "HumanoidStandup":
            tasks.append(Task(f"{body}Wall", body, (RangeSensor(), Wall(width))))
    return tasks


def arms() -> list[Task]:
    """Pushing and striking, with fixed and with drawn places."""
    return [
        Task("Striker", "Striker", max_steps=ARM_STEPS),
        Task("StrikerMovingStart", "Striker", (MovingStart(),), max_steps=ARM_STEPS),
        Task("Pusher", "Pusher", max_steps=ARM_STEPS),
        Task("PusherMovingGoal", "Pusher", (MovingGoal(),), max_steps=ARM_STEPS),
    ]


def extras() -> list[Task]:
    """What the paper announced for future releases: motor noise, noisy sensors, goals that move."""
    noisy = [Task(f"{body}MotorNoise", body, (MotorNoise(),)) for body in RUNNING_BODIES]
    blurred = [
        Task(f"{body}NoisyWall", body, (RangeSensor(), Wall(WALL_WIDTHS[body]), SensorNoise()))
        for body in RUNNING_BODIES
    ]
    pusher = Task("PusherTrackingGoal", "Pusher", (MovingGoal(), TrackingGoal()), max_steps=ARM_STEPS)
    striker = Task("StrikerTrackingGoal", "Striker", (TrackingGoal(),), max_steps=ARM_STEPS)
    return [*noisy, *blurred, pusher, striker]


def body_tasks() -> list[Task]:
    """Every MuJoCo task."""
    return [*running(), *gravity(), *morphology(), *standing_up(), *walls(), *arms(), *extras()]
