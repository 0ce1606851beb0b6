"""What the rest of ``envs`` asks of navigation: an environment, a vector of them, the bytes of a map."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from gym_extensions.catalog.task import Task
from gym_extensions.envs.navigation.env import Navigation, course
from gym_extensions.envs.navigation.grid import arena, map_bytes
from gym_extensions.envs.navigation.vector_env import NavigationVector


def construct(task: Task, **rendering: Any) -> Navigation:
    """The task's environment without wrappers; ``rendering`` may hold ``render_mode``."""
    return Navigation(task, **rendering)


def construct_batch(lanes: Sequence[Task]) -> NavigationVector:
    """The vector environment whose lane i holds the i-th task."""
    return NavigationVector(lanes)


def base_bytes(task: Task) -> bytes:
    """What a navigation task is made from: the bytes of its map's file and a line with its goal's centre."""
    drawn = course(task)
    x, y = arena(drawn.map, drawn.goal).goal
    return map_bytes(drawn.map) + f"goal {x:g} {y:g}\n".encode("ascii")
