"""Which parts a task has, and which variations fit which base body."""

from __future__ import annotations

from typing import TypeVar

from gym_extensions.catalog.task import Task
from gym_extensions.catalog.variations.actuation import MotorNoise
from gym_extensions.catalog.variations.goals import MovingGoal, MovingStart, TrackingGoal
from gym_extensions.catalog.variations.gravity import Gravity
from gym_extensions.catalog.variations.obstacles import RangeSensor, SensorNoise, Wall
from gym_extensions.envs.effects.base import Part
from gym_extensions.envs.effects.motor_noise import Motors
from gym_extensions.envs.effects.moving_goal import Tracking
from gym_extensions.envs.effects.range_sensor import FANS
from gym_extensions.envs.effects.sensing import Sensor, StandingWall
from gym_extensions.errors import BenchError

Kind = TypeVar("Kind")

FITS: dict[type, tuple[str, ...]] = {
    Gravity: tuple(FANS),
    Wall: tuple(FANS),
    RangeSensor: tuple(FANS),
    SensorNoise: tuple(FANS),
    MovingGoal: ("Pusher",),
    MovingStart: ("Striker",),
    TrackingGoal: ("Pusher", "Striker"),
}
"""The base bodies of the variations that do not fit every one: the arms have no gravity and no torso."""


def parts(task: Task) -> list[Part]:
    """The parts of a task in the order in which they draw: wall, sensor, motors, goal.

    Raises:
        BenchError: a variation does not fit the base body, or acts twice.
    """
    _check(task)
    wall, noise, motor = _one(task, Wall), _one(task, SensorNoise), _one(task, MotorNoise)
    tracking = _one(task, TrackingGoal)
    found: list[Part] = []
    if wall is not None and not wall.parked:
        found.append(StandingWall(wall))
    if _one(task, RangeSensor) is not None:
        found.append(Sensor(task, wall, noise))
    elif noise is not None:
        raise BenchError("no-sensor", "There is no RangeSensor for SensorNoise to disturb.", task.id)
    if motor is not None:
        found.append(Motors(task, motor))
    return [*found, Tracking(task, tracking)] if tracking is not None else found


def _check(task: Task) -> None:
    for variation in task.variations:
        fitting = FITS.get(type(variation), (task.base,))
        if task.base not in fitting:
            message = f"{type(variation).__name__} does not fit {task.base}."
            raise BenchError("misplaced-variation", message, hint=f"It fits {', '.join(fitting)}.")


def _one(task: Task, kind: type[Kind]) -> Kind | None:
    found = [variation for variation in task.variations if isinstance(variation, kind)]
    if len(found) > 1:
        message = f"The variation {kind.__name__} is given {len(found)} times."
        raise BenchError("repeated-variation", message, hint="Give it once.")
    return found[0] if found else None
