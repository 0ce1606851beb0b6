"""The environments; importing this registers every id with Gymnasium."""

from gym_extensions.catalog.groups import TaskGroup, group
from gym_extensions.catalog.tasks import Task
from gym_extensions.catalog.variations import Gravity
from gym_extensions.envs.batch import make_batch
from gym_extensions.envs.build import make
from gym_extensions.envs.registration import register

__all__ = ["Gravity", "Task", "TaskGroup", "group", "make", "make_batch"]

register()
