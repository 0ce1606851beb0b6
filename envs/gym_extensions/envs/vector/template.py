"""What all copies of one task share, taken from its single environment."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import mujoco
from gymnasium.spaces import Box

from gym_extensions.catalog.task import Task
from gym_extensions.envs.make import construct_mujoco
from gym_extensions.envs.protocols import Array


@dataclass(frozen=True, eq=False)
class TaskTemplate:
    """A task's compiled model, spaces and rest pose."""

    task: Task
    model: mujoco.MjModel
    frame_skip: int
    init_qpos: Array
    init_qvel: Array
    observation_space: Box
    action_space: Box
    root_lift: float
    """Height of the torso's frame when the root's vertical coordinate is 0, m; 0 for the arms."""

    def __reduce__(self) -> tuple[Callable[[Task], TaskTemplate], tuple[Task]]:
        """A copy compiles the task's model again."""
        return template, (self.task,)

    @property
    def dt(self) -> float:
        """Seconds per environment step, computed as Gymnasium computes it."""
        return float(self.model.opt.timestep * self.frame_skip)


def template(task: Task) -> TaskTemplate:
    """Builds the single environment of a MuJoCo task and returns its template."""
    env = construct_mujoco(task)
    start = env.init_qpos.copy(), env.init_qvel.copy()
    spaces = env.observation_space, env.action_space
    lift = env.root_lift if task.body.beams is not None else 0.0
    return TaskTemplate(task, env.model, env.frame_skip, *start, *spaces, lift)
