"""What a variation does at run time, on whole arrays: called by a lot at fixed moments."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gym_extensions.envs.vector.physics import Array, Lanes

Steps = NDArray[np.int64]


class LanePart:
    """A part that does nothing; kinds of parts override what they need. ``steps`` count from each reset."""

    def draw(self, lanes: Lanes, generators: Sequence[np.random.Generator], rows: dict[str, Array]) -> None:
        """Draws after the body, and adds to the rows of the state in which the lanes start."""

    def started(self, lanes: Lanes) -> None:
        """Takes note that some lanes have started an episode."""

    def before(self, steps: Steps) -> None:
        """Acts before the physics of a step; rows of lanes that are not stepped mean nothing."""

    def applied(self, ctrl: NDArray[Any], steps: Steps) -> NDArray[Any]:
        """What the motors get for commands."""
        return ctrl

    def observed(self) -> Array | None:
        """What the part appends to the observations, ``(lanes, …)``."""
        return None

    def carried(self) -> dict[str, Array]:
        """Copies of the part's own state by name, every lane's."""
        return {}

    def carry(self, lanes: Lanes, state: Mapping[str, Array]) -> None:
        """Takes saved rows back into some lanes; derived values may be absent."""
