"""The environments; importing this registers every id with Gymnasium."""

from gym_extensions.catalog.groups import TaskGroup, group
from gym_extensions.catalog.limbs import LimbScale
from gym_extensions.catalog.scenery import RangeSensor, SensorNoise, Wall
from gym_extensions.catalog.tasks import Task
from gym_extensions.catalog.variations import Gravity, MotorNoise, MovingGoal, MovingStart, TrackingGoal
from gym_extensions.envs.batch import make_batch
from gym_extensions.envs.build import make
from gym_extensions.envs.registration import register
from gym_extensions.envs.task_id import TaskId, VectorTaskId

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
    "group",
    "make",
    "make_batch",
]

register()
