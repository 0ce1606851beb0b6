"""Wrappers that append the task to the observation, as a one-hot vector."""

from collections.abc import Sequence
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.spaces import Box
from gymnasium.vector import VectorEnv, VectorObservationWrapper
from numpy.typing import NDArray

from gym_extensions.catalog.groups import TaskGroup, resolve_group
from gym_extensions.catalog.tasks import Task, customize
from gym_extensions.errors import BenchError

Tasks = str | TaskGroup | Sequence[str | Task]


def one_hot(task: Task, tasks: Tasks) -> NDArray[np.float64]:
    """Returns a vector (tasks,) with 1 at the index of the task and 0 elsewhere.

    Raises ``BenchError`` if the task is not in the list.
    """
    named = resolve_group(tasks).tasks if isinstance(tasks, str | TaskGroup) else tasks
    members = [customize(each) for each in named]
    if task not in members:
        names = ", ".join(member.name for member in members)
        raise BenchError("foreign-task", f"{task.id} is not one of {names}.", "TaskId", "Pass its group.")
    return np.array([float(member == task) for member in members])


def _appended(space: gym.Space[Any], length: int) -> Box:
    """Returns the space with elements in [0, 1] appended. Raises ``BenchError`` unless it is a flat Box."""
    if not isinstance(space, Box) or len(space.shape) != 1:
        message = f"The observation space {space} is not a vector."
        raise BenchError("no-vector", message, "TaskId", "Give the task to the agent as a separate input.")
    low, high = np.append(space.low, np.zeros(length)), np.append(space.high, np.ones(length))
    return Box(low.astype(space.dtype), high.astype(space.dtype), dtype=space.dtype.type)


class TaskId(gym.ObservationWrapper[Any, Any, Any], gym.utils.RecordConstructorArgs):
    """One environment whose observations end with its task's one-hot vector.

    Args:
        env: an environment of one of the tasks.
        tasks: a group or its name, or the tasks in the order of the vector's elements.
    """

    def __init__(self, env: gym.Env[Any, Any], tasks: Tasks) -> None:
        gym.utils.RecordConstructorArgs.__init__(self, tasks=tasks)
        super().__init__(env)
        self._id = one_hot(env.get_wrapper_attr("task"), tasks)
        self.observation_space = _appended(env.observation_space, self._id.size)

    def observation(self, observation: NDArray[Any]) -> NDArray[Any]:
        """Appends the vector, in the precision of the observation."""
        return np.concatenate([observation, self._id.astype(observation.dtype)])


class VectorTaskId(VectorObservationWrapper):
    """A vector environment whose observations end with the one-hot vectors of their tasks.

    Args:
        env: a vector environment of the tasks.
        tasks: a group or its name, or the tasks in the order of the vector's elements.
    """

    def __init__(self, env: VectorEnv[Any, Any, Any], tasks: Tasks) -> None:
        super().__init__(env)
        environments: Any = env  # VectorEnv does not declare call, but its implementations have it
        self._ids = np.stack([one_hot(task, tasks) for task in environments.call("task")])
        self.single_observation_space = _appended(env.single_observation_space, self._ids.shape[1])
        self.observation_space = gym.vector.utils.batch_space(self.single_observation_space, env.num_envs)

    def observations(self, observations: NDArray[Any]) -> NDArray[Any]:
        """Appends each environment's vector to its observation, (num_envs, …)."""
        return np.concatenate([observations, self._ids.astype(observations.dtype)], axis=1)
