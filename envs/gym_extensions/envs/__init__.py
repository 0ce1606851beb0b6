"""The environments. Importing this package registers every published id with Gymnasium.

It warns if MuJoCo or Gymnasium has another version than that of the published tasks.
"""

from gym_extensions.catalog import variations
from gym_extensions.catalog.groups import TaskGroup, group, load_group
from gym_extensions.catalog.tasks import Task, customize
from gym_extensions.catalog.variations import *  # noqa: F403
from gym_extensions.catalog.variations import Variation
from gym_extensions.envs.fingerprinting import warn_of_another_engine
from gym_extensions.envs.make import make, make_vec, register
from gym_extensions.envs.wrappers import TaskId, VectorTaskId

__all__ = [
    "Task",
    "TaskGroup",
    "TaskId",
    "Variation",
    "VectorTaskId",
    "customize",
    "group",
    "load_group",
    "make",
    "make_vec",
]
__all__ += variations.__all__

register()
warn_of_another_engine()
