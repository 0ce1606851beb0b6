"""The environments. Importing this package registers every published id with Gymnasium.

It warns if MuJoCo or Gymnasium has another version than that of the published tasks.
"""

from gym_extensions.catalog.custom import customize
from gym_extensions.catalog.custom_groups import load_group
from gym_extensions.catalog.groups import TaskGroup, group
from gym_extensions.catalog.task import Task
from gym_extensions.catalog.variations.actuation import MotorNoise
from gym_extensions.catalog.variations.goals import MovingGoal, MovingStart, TrackingGoal
from gym_extensions.catalog.variations.gravity import Gravity
from gym_extensions.catalog.variations.morphology import LimbScale
from gym_extensions.catalog.variations.obstacles import RangeSensor, SensorNoise, Wall
from gym_extensions.envs.fingerprint import warn_of_another_engine
from gym_extensions.envs.make import make
from gym_extensions.envs.make_vec import make_vec
from gym_extensions.envs.registration import register
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
