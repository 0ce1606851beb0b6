"""The interface of navigation for the rest of ``envs``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from gym_extensions.catalog.task import Task
from gym_extensions.envs.navigation.env import Navigation, course
from gym_extensions.envs.navigation.grid import arena, map_bytes
from gym_extensions.envs.navigation.vector_env import NavigationVectorEnv


def construct(task: Task, **rendering: Any) -> Navigation:
    """Returns the task's environment without wrappers. ``rendering`` may have ``render_mode``."""
    return Navigation(task, **rendering)


def construct_vector(tasks: Sequence[Task]) -> NavigationVectorEnv:
    """Returns the vector environment whose environment i has the i-th task."""
    return NavigationVectorEnv(tasks)


def base_bytes(task: Task) -> bytes:
    """Returns the bytes of the task's map file, and a line with the center of its goal."""
    row = course(task)
    x, y = arena(row.map, row.goal).goal
    return map_bytes(row.map) + f"goal {x:g} {y:g}\n".encode("ascii")
