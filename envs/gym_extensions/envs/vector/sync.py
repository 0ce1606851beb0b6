"""Environments stepped one by one, for tasks without rules on arrays."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from gymnasium.vector import SyncVectorEnv

from gym_extensions.envs.seeding import spawn_seeds


class SequentialVectorEnv(SyncVectorEnv):
    """Gymnasium's SyncVectorEnv, with an integer reset seed spawned into one seed per environment."""

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Returns the first observations. An int seed is spawned, a list has one seed per environment."""
        seeds = spawn_seeds(seed, self.num_envs) if isinstance(seed, int) else seed
        return super().reset(seed=seeds, options=options)  # type: ignore[arg-type]
