"""Registers every published task with Gymnasium."""

from __future__ import annotations

import gymnasium as gym

from gym_extensions.catalog.registry import TASKS
from gym_extensions.envs.make import ENTRY_POINT, VECTOR_ENTRY_POINT


def register() -> None:
    """Registers each published id once, for ``gymnasium.make`` and ``gymnasium.make_vec``."""
    for row in TASKS.values():
        if row.id not in gym.registry:
            gym.register(
                row.id,
                entry_point=ENTRY_POINT,
                vector_entry_point=VECTOR_ENTRY_POINT,
                max_episode_steps=row.max_steps,
                kwargs={"task": row.id},
            )
