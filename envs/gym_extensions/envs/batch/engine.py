"""What a vector environment needs from the simulations that it steps."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from gym_extensions.envs.batch.infos import Part
from gym_extensions.envs.protocols import Array, Flags, Indices, States

GeneratorOf = Callable[[int], np.random.Generator]
"""Returns the generator of an environment."""


class Engine(Protocol):
    """The simulations of a vector environment. Its copies and pickles keep the exact state."""

    def check_options(self, options: Mapping[str, Any], indices: Indices) -> None:
        """Raises ``BenchError`` for reset options with which these environments cannot start."""

    def start(self, indices: Indices, generator: GeneratorOf, options: Mapping[str, Any]) -> None:
        """Starts episodes in some environments, with checked options."""

    def step(self, actions: NDArray[Any], resting: Flags | None) -> tuple[Array, Flags]:
        """Returns new arrays of rewards and terminations of one step. Rows of resting ones are ignored."""

    def observe(self) -> NDArray[Any]:
        """Returns a new array of observations, ``(num_envs, …)``."""

    def step_infos(self) -> list[Part]:
        """Returns the infos of the last step as new arrays. Rows of resting environments are ignored."""

    def reset_infos(self) -> list[Part]:
        """Returns the infos of a reset as new arrays. Rows of other environments are ignored."""

    def save(self) -> dict[str, Array]:
        """Returns copies of the states by name, ``(num_envs, …)``."""

    def save_each(self) -> list[dict[str, Array]]:
        """Returns one state per environment, with the names that its task has."""

    def load(self, indices: Indices, states: States) -> None:
        """Restores saved rows, one per given environment, or raises ``BenchError`` and changes nothing."""

    def close(self) -> None:
        """Frees threads and memory."""
