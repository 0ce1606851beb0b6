"""Many copies of tasks stepped at once, as a Gymnasium vector environment."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode, SyncVectorEnv

from gym_extensions.catalog.tasks import Task
from gym_extensions.envs.build import make


def lane_seeds(seed: int, num_envs: int) -> list[int]:
    """One seed a lane, spawned from one seed, so that neighbouring seeds share no lane."""
    return [int(child.generate_state(1)[0]) for child in np.random.SeedSequence(seed).spawn(num_envs)]


class LaneSeeded(SyncVectorEnv):
    """A vector environment whose integer reset seed is spawned into lane seeds."""

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """First observations of every lane; an int seed is spawned, a list gives lane i its own."""
        seeds = lane_seeds(seed, self.num_envs) if isinstance(seed, int) else seed
        return super().reset(seed=seeds, options=options)  # type: ignore[arg-type]


def make_batch(
    tasks: str | Task | Sequence[str | Task], num_envs: int, num_threads: int = 1
) -> gym.vector.VectorEnv[Any, Any, Any]:
    """``num_envs`` lanes, lane i holding ``tasks[i mod len(tasks)]``, in autoreset mode NEXT_STEP."""
    rows = [tasks] if isinstance(tasks, str | Task) else list(tasks)
    makers = [partial(make, rows[lane % len(rows)]) for lane in range(num_envs)]
    return LaneSeeded(makers, autoreset_mode=AutoresetMode.NEXT_STEP)
