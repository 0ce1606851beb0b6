"""How a task differs from its base body, in sentences."""

from __future__ import annotations

from gym_extensions.catalog.task import Task
from gym_extensions.catalog.variations.base import BaseVariation, Variation
from gym_extensions.envs.mujoco.compile import base_spec


def differences(task: Task) -> list[str]:
    """Returns one sentence per variation of a task."""
    if task.body.family == "navigation":
        return [_course(task)]
    return [_sentence(task, variation) for variation in task.variations]


def _sentence(task: Task, variation: Variation) -> str:
    if isinstance(variation, BaseVariation):
        return variation.describe(task.body, base_spec(task.body))
    return f"{variation!r}."


def _course(task: Task) -> str:
    from gym_extensions.envs.navigation.env import course
    from gym_extensions.envs.navigation.grid import arena

    row = course(task)
    x, y = arena(row.map, row.goal).goal
    return f"Map {row.map}, goal {row.goal} at ({x:g}, {y:g})."
