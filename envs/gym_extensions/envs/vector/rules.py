"""What a body family adds to physics, on whole arrays over lanes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from gym_extensions.envs.vector.physics import Array, Lanes, Physics
from gym_extensions.envs.vector.template import Prototype

Flags = NDArray[np.bool_]


class Rules(Protocol):
    """Reset draws, observation, reward and end of a family, all lanes at once."""

    def draw(self, lanes: Lanes, generators: Sequence[np.random.Generator]) -> dict[str, Array]:
        """Rows of the state in which some lanes start an episode.

        Each is drawn from its own generator, with the numbers that the single environment takes from it.
        """

    def started(self, lanes: Lanes) -> None:
        """Takes note that some lanes have started an episode."""

    def before(self) -> None:
        """Takes note of what the reward compares with, before a step."""

    def outcome(self, actions: NDArray[Any], ctrl: NDArray[Any]) -> tuple[Array, Flags]:
        """Rewards and terminations after a step; rows of lanes that were not stepped mean nothing.

        Args:
            actions: ``(lanes, nu)`` as the agent gave them, in the agent's own precision.
            ctrl: the same as the motors got them.
        """

    def observe(self) -> Array:
        """A new array of observations."""

    def carried(self) -> dict[str, Array]:
        """Copies of what a saved state holds beside the physics, every lane's."""

    def carry(self, lanes: Lanes, state: Mapping[str, Array]) -> None:
        """Takes saved rows of the carried values into some lanes, after physics; derived ones may lack."""


class MakesRules(Protocol):
    """A family: what it reads of physics, and its rules over given lanes."""

    pooled: bool
    """Whether it reads what mj_rnePostConstraint computes."""
    fields: tuple[str, ...]
    """Derived fields of MjData that it reads."""

    def __call__(self, physics: Physics, lanes: Sequence[Prototype]) -> Rules:
        """The rules over lanes that hold these prototypes."""
