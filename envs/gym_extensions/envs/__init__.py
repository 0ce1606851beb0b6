"""The environments. Importing this package registers every published id with Gymnasium.

It warns if MuJoCo or Gymnasium has another version than that of the published tasks.
"""

from gym_extensions.catalog.groups import TaskGroup, group, load_group
from gym_extensions.catalog.tasks import Task, customize
from gym_extensions.catalog.variations import (
    Gravity,
    LimbScale,
    MotorNoise,
    MovingGoal,
    MovingStart,
    RangeSensor,
    SensorNoise,
    TrackingGoal,
    Wall,
)
from gym_extensions.envs.fingerprinting import warn_of_another_engine
from gym_extensions.envs.make import make, make_vec, register
from gym_extensions.envs.wrappers import TaskId, VectorTaskId

__all__ = [
    "Gravity",
    "LimbScale",
    "MotorNoise",
    "MovingGoal",
    "MovingStart",
    "RangeSensor",
    "SensorNoise",
    "Task",
    "TaskGroup",
    "TaskId",
    "TrackingGoal",
    "VectorTaskId",
    "Wall",
    "customize",
    "group",
    "load_group",
    "make",
    "make_vec",
]

register()
warn_of_another_engine()
