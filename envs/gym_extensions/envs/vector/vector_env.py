"""The MuJoCo vector environment."""

from __future__ import annotations

from collections.abc import Sequence

from gym_extensions.envs.batch.vector_env import TaskVectorEnv
from gym_extensions.envs.vector.shards import Shards
from gym_extensions.envs.vector.template import TaskTemplate


class MujocoVectorEnv(TaskVectorEnv):
    """MuJoCo environments stepped together.

    Args:
        templates: the task of each environment, with its compiled model.
        num_threads: threads that step physics.
    """

    def __init__(self, templates: Sequence[TaskTemplate], num_threads: int) -> None:
        spaces = templates[0].observation_space, templates[0].action_space
        super().__init__([row.task for row in templates], spaces, Shards(templates, num_threads))
