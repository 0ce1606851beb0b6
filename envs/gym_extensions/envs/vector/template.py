"""What a lane takes from its task's single environment, built once a task."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
from gymnasium.spaces import Box

from gym_extensions.catalog.task import Task
from gym_extensions.envs.effects.range_sensor import FANS
from gym_extensions.envs.make import construct
from gym_extensions.envs.mujoco.task_env import TaskEnv
from gym_extensions.envs.vector.physics import Array


@dataclass(frozen=True, eq=False)
class Prototype:
    """A task's compiled model, spaces and starting point; shared by all its lanes."""

    task: Task
    model: mujoco.MjModel
    frame_skip: int
    init_qpos: Array
    init_qvel: Array
    observation_space: Box
    action_space: Box
    root_lift: float
    """Height of the torso's frame when the root's vertical coordinate is 0, m; 0 for the arms."""

    @property
    def dt(self) -> float:
        """Seconds an environment step, computed as Gymnasium computes it."""
        return float(self.model.opt.timestep * self.frame_skip)


def prototype(task: Task) -> Prototype:
    """The prototype of a task, taken from its single environment."""
    body = construct(task).unwrapped
    if not isinstance(body, TaskEnv):
        raise ValueError(f"{task.id} is no MuJoCo task")
    observations, actions = body.observation_space, body.action_space
    if not (isinstance(observations, Box) and isinstance(actions, Box)):
        raise ValueError(f"{task.id} has spaces that are no boxes")
    starts = body.init_qpos.copy(), body.init_qvel.copy()
    lift = body.root_lift if task.base in FANS else 0.0
    return Prototype(task, body.model, body.frame_skip, *starts, observations, actions, lift)
