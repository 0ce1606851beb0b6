"""Makes the environment of a task."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import gymnasium as gym
from gymnasium.envs.registration import EnvSpec

from gym_extensions.catalog.custom import customize
from gym_extensions.catalog.registry import TASKS
from gym_extensions.catalog.registry import task as published_task
from gym_extensions.catalog.task import Task
from gym_extensions.catalog.variations.base import Variation
from gym_extensions.envs.bodies import implementation
from gym_extensions.envs.mujoco.task_env import TaskEnv

ENTRY_POINT = "gym_extensions.envs.make:construct"


def construct(task: str | Task, **rendering: Any) -> gym.Env[Any, Any]:
    """Returns the task's environment without wrappers, as Gymnasium's registry calls it.

    Args:
        task: an id, a bare name, or a Task.
        rendering: ``render_mode``, and for MuJoCo bodies Gymnasium's camera arguments.

    Raises:
        BenchError: the task or its base body is unknown, or a variation does not fit the body.
    """
    row = task if isinstance(task, Task) else published_task(task)
    if row.body.family == "navigation":
        from gym_extensions.envs.navigation.build import construct as construct_navigation

        environment: gym.Env[Any, Any] = construct_navigation(row, **rendering)
        return environment
    return construct_mujoco(row, **rendering)


def construct_mujoco(task: str | Task, **rendering: Any) -> TaskEnv:
    """Returns the environment of a MuJoCo task without wrappers, with its MuJoCo types."""
    row = task if isinstance(task, Task) else published_task(task)
    return implementation(row.body.name).env(row, **rendering)


def make(
    task: str | Task,
    variations: Sequence[Variation] = (),
    *,
    render_mode: str | None = None,
    max_steps: int | None = None,
) -> gym.Env[Any, Any]:
    """Returns the environment of a published or custom task, with its time limit.

    Args:
        task: an id (``gym_extensions/HopperGravityHalf-v0``), a bare name (``HopperGravityHalf``), or a Task.
        variations: added to the task's own. If the result equals a published task, it is that task.
        render_mode: as in ``gymnasium.make``.
        max_steps: the time limit in environment steps; None keeps the task's.

    Raises:
        BenchError: the task is unknown, the limit is below 1, or a variation does not fit the base body.
    """
    row = customize(task, variations, max_steps=max_steps)
    if TASKS.get(row.id) == row:
        return gym.make(row.id, render_mode=render_mode, disable_env_checker=True)
    spec = EnvSpec(row.id, entry_point=ENTRY_POINT, max_episode_steps=row.max_steps, kwargs={"task": row})
    return gym.make(spec, render_mode=render_mode, disable_env_checker=True)
