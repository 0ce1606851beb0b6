"""Task -> gymnasium.Env."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import gymnasium as gym
from gymnasium.envs.registration import EnvSpec

from gym_extensions.catalog.custom import varied
from gym_extensions.catalog.registry import TASKS
from gym_extensions.catalog.registry import task as published
from gym_extensions.catalog.task import Task
from gym_extensions.catalog.variations.base import Variation
from gym_extensions.envs.mujoco import humanoid, pusher, striker
from gym_extensions.envs.mujoco import planar as running
from gym_extensions.envs.mujoco.task_env import TaskEnv
from gym_extensions.errors import BenchError, did_you_mean

BODIES: dict[str, type[TaskEnv]] = {
    "Hopper": running.Hopper,
    "Walker2d": running.Walker2d,
    "HalfCheetah": running.HalfCheetah,
    "Humanoid": humanoid.Humanoid,
    "HumanoidStandup": humanoid.HumanoidStandup,
    "HumanoidStandupAndRun": humanoid.HumanoidStandupAndRun,
    "Pusher": pusher.Pusher,
    "Striker": striker.Striker,
}
"""The class of every MuJoCo base body."""

ENTRY_POINT = "gym_extensions.envs.make:construct"


def construct(task: str | Task, **rendering: Any) -> gym.Env[Any, Any]:
    """The task's environment without wrappers; this is what Gymnasium's registry calls.

    Args:
        task: an id, a bare name, or a Task.
        rendering: ``render_mode`` and the camera arguments of Gymnasium's MuJoCo bodies.

    Raises:
        BenchError: there is no such task, or no such base body.
    """
    row = task if isinstance(task, Task) else published(task)
    if row.base == "Navigation":
        from gym_extensions.envs.navigation.build import construct as navigation

        built: gym.Env[Any, Any] = navigation(row, **rendering)
        return built
    if row.base not in BODIES:
        hint = did_you_mean(row.base, BODIES)
        raise BenchError("unknown-base", f"There is no base body {row.base!r}.", row.id, hint)
    return BODIES[row.base](row, **rendering)


def make(
    task: str | Task,
    variations: Sequence[Variation] = (),
    *,
    render_mode: str | None = None,
    max_steps: int | None = None,
) -> gym.Env[Any, Any]:
    """The environment of a task, published or free, with its time limit.

    Args:
        task: an id (``gym_extensions/HopperGravityHalf-v0``), a bare name (``HopperGravityHalf``), or a Task.
        variations: added to the task's own. If the result is a published task, it is that task.
        render_mode: as in ``gymnasium.make``.
        max_steps: steps after which an episode is cut off; the task's own limit if None.

    Raises:
        BenchError: there is no such task, a limit below 1, or a variation that does not fit the base body.
    """
    given: object = variations
    if not isinstance(given, Iterable):
        message = f"variations is {variations!r}."
        raise BenchError("no-list", message, hint="Give a list, even of one variation.")
    row = varied(task if isinstance(task, Task) else published(task), tuple(variations), max_steps)
    if TASKS.get(row.id) == row:
        return gym.make(row.id, render_mode=render_mode, disable_env_checker=True)
    spec = EnvSpec(row.id, entry_point=ENTRY_POINT, max_episode_steps=row.max_steps, kwargs={"task": row})
    return gym.make(spec, render_mode=render_mode, disable_env_checker=True)
