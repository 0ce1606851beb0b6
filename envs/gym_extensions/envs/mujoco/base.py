"""What a family of bodies adds to physics: start, observation, reward and end, on arrays."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from gym_extensions.envs.interfaces import Array, Fields, Flags, Generators, Indices, Template


class Rules:
    """The rules of the environments of one shard. Most keep nothing between steps."""

    needs_contact_forces: ClassVar[bool] = False
    """Whether they read the results of mj_rnePostConstraint."""
    fields: ClassVar[tuple[str, ...]] = ()
    """Derived fields of MjData that they read."""
    kept: ClassVar[tuple[str, ...]] = ()
    """Attributes beside the physics on which later steps depend; copies have them too."""

    def __init__(self, physics: Fields, templates: Sequence[Template]) -> None:
        self._templates = templates

    def draw(self, indices: Indices, generators: Generators) -> dict[str, Array]:
        """Draws the states in which some environments start an episode, one row each, by name.

        Each is drawn from its own generator, with the numbers that the single environment takes from it.
        """
        raise NotImplementedError

    def on_reset(self, indices: Indices) -> None:
        """Acts after some environments have started an episode."""

    def pre_step(self) -> None:
        """Stores what the reward compares with, before a step."""

    def reward_and_termination(self, actions: NDArray[Any], ctrl: NDArray[Any]) -> tuple[Array, Flags]:
        """Returns rewards and terminations after a step, ``(num_envs,)`` each.

        Rows of environments that were not stepped are meaningless.

        Args:
            actions: ``(num_envs, nu)`` from the agent, in the agent's precision.
            ctrl: ``(num_envs, nu)`` as the motors received them.
        """
        raise NotImplementedError

    def step_infos(self) -> dict[str, NDArray[Any]]:
        """Returns the single environment's infos of the last step by key, as new arrays."""
        return {}

    def reset_infos(self) -> dict[str, NDArray[Any]]:
        """Returns the single environment's infos of a reset by key, as new arrays."""
        return {}

    def observe(self) -> Array:
        """Returns a new array of observations."""
        raise NotImplementedError


def uniform_rows(generators: Generators, noise: float, size: int) -> Array:
    """Draws ``size`` numbers in [−noise, noise) from each generator, (generators, size)."""
    return np.array([generator.uniform(-noise, noise, size) for generator in generators])


def uniform_state(generators: Generators, noise: float, nq: int, nv: int) -> tuple[Array, Array]:
    """Draws rows of nq, then of nv numbers. One call gives the numbers of two calls in a row."""
    rows = uniform_rows(generators, noise, nq + nv)
    return rows[:, :nq], rows[:, nq:]
