"""Lanes stepped through their single environments, for tasks without whole-array rules."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from gymnasium.vector import SyncVectorEnv

from gym_extensions.envs.seeding import lane_seeds


class OneByOne(SyncVectorEnv):
    """Gymnasium's SyncVectorEnv whose integer reset seed is spawned into lane seeds."""

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """First observations of every lane; an int seed is spawned, a list gives lane i its own."""
        seeds = lane_seeds(seed, self.num_envs) if isinstance(seed, int) else seed
        return super().reset(seed=seeds, options=options)  # type: ignore[arg-type]
