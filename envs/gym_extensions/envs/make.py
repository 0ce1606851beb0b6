"""Makes the environment of a task."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import gymnasium as gym
from gymnasium.envs.registration import EnvSpec

from gym_extensions.catalog.custom import customize
from gym_extensions.catalog.definitions import definition, is_definable
from gym_extensions.catalog.registry import TASKS
from gym_extensions.catalog.task import Task
from gym_extensions.catalog.variations.base import Variation
from gym_extensions.envs.bodies import implementation
from gym_extensions.envs.gym_request import check_keywords, request, resolve
from gym_extensions.envs.mujoco.task_env import TaskEnv

ENTRY_POINT = "gym_extensions.envs.make:construct"
RENDER_MODES = ["human", "rgb_array", "depth_array", "rgbd_tuple"]
"""Those of Gymnasium's MuJoCo environments. From them Gymnasium makes others, such as ``rgb_array_list``."""
VECTOR_ENTRY_POINT = "gym_extensions.envs.make_vec:construct"


def construct(task: str | Task | Mapping[str, Any], **rendering: Any) -> gym.Env[Any, Any]:
    """Returns the task's environment without wrappers, as Gymnasium's registry calls it.

    Args:
        task: an id, a bare name, a Task, or a task's definition as plain data.
        rendering: ``render_mode``, and for MuJoCo bodies Gymnasium's sizes and camera arguments.

    Raises:
        BenchError: the task or its base body is unknown, a variation does not fit the body, or a keyword or
            the time limit of ``gymnasium.make`` would change the task.
    """
    row = resolve(task, request())
    check_keywords(row, rendering)
    return build(row, **rendering)


construct.metadata = {"render_modes": RENDER_MODES}  # type: ignore[attr-defined]  # read by gymnasium.make


def build(row: Task, **rendering: Any) -> gym.Env[Any, Any]:
    """Returns the environment of exactly this task, whatever its id: fingerprints compare both."""
    if row.body.family != "navigation":
        return implementation(row.body.name).env(row, **rendering)
    from gym_extensions.envs.navigation.build import construct as construct_navigation

    environment: gym.Env[Any, Any] = construct_navigation(row, **rendering)
    return environment


def construct_mujoco(task: str | Task, **rendering: Any) -> TaskEnv:
    """Returns the environment of a MuJoCo task without wrappers, with its MuJoCo types."""
    row = resolve(task)
    check_keywords(row, rendering)
    return implementation(row.body.name).env(row, **rendering)


def make(
    task: str | Task,
    variations: Sequence[Variation] = (),
    *,
    render_mode: str | None = None,
    max_steps: int | None = None,
) -> gym.Env[Any, Any]:
    """Returns the environment of a published or custom task, with its time limit.

    Its ``spec`` can be written with ``to_json`` and made again with ``gymnasium.make``, unless the task has
    variations of your own classes.

    Args:
        task: an id (``gym_extensions/HopperGravityHalf-v0``), a bare name (``HopperGravityHalf``), or a Task.
        variations: added to the task's own. If the result equals a published task, it is that task.
        render_mode: as in ``gymnasium.make``.
        max_steps: the time limit in environment steps; None keeps the task's.

    Raises:
        BenchError: the task is unknown, the limit is below 1, or a variation does not fit the base body.
    """
    row = customize(task, variations, max_steps=max_steps)
    spec = row.id if TASKS.get(row.id) == row else spec_of(row)
    return gym.make(spec, render_mode=render_mode, disable_env_checker=True)


def spec_of(row: Task) -> EnvSpec:
    """Returns Gymnasium's spec of a task that is not registered."""
    return EnvSpec(
        row.id,
        entry_point=ENTRY_POINT,
        vector_entry_point=VECTOR_ENTRY_POINT,
        max_episode_steps=row.max_steps,
        kwargs={"task": definition(row) if is_definable(row) else row},
    )
