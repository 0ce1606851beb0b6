"""What a variation does while the simulation runs, as a part that the environment calls at fixed moments."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gym_extensions.envs.state import State

if TYPE_CHECKING:
    from gym_extensions.envs.mujoco.task_env import TaskEnv

NOISE_SEEDS = 2**32
"""An episode's noise follows from one number below this, drawn at reset: replay needs no generator state."""


class Part:
    """A part that does nothing; kinds of parts override what they need."""

    def reset(self, env: TaskEnv) -> None:
        """Draws and places at reset, after the body's own draws; derived quantities are recomputed later."""

    def before(self, env: TaskEnv) -> None:
        """Acts before the physics of a step."""

    def applied(self, env: TaskEnv, ctrl: NDArray[Any]) -> NDArray[Any]:
        """What the motors get for a command."""
        return ctrl

    def observed(self, env: TaskEnv) -> NDArray[np.float64]:
        """What the part appends to the observation."""
        return np.zeros(0)

    def carried(self) -> State:
        """The part's own state by name."""
        return {}

    def carry(self, saved: Mapping[str, NDArray[np.float64]]) -> None:
        """Takes back what ``carried`` gave; derived values may be absent."""
