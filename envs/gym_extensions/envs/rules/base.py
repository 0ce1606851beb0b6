"""What a family of bodies adds to physics."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

from numpy.typing import NDArray

from gym_extensions.envs.protocols import Array, Flags, Generators, Indices, Physics, States, Template


class Rules(Protocol):
    """Start, observation, reward and end of the environments of one shard."""

    def draw(self, indices: Indices, generators: Generators) -> dict[str, Array]:
        """Draws the states in which some environments start an episode, one row each, by name.

        Each is drawn from its own generator, with the numbers that the single environment takes from it.
        """

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

    def step_infos(self) -> dict[str, NDArray[Any]]:
        """Returns the single environment's infos of the last step by key, as new arrays."""

    def reset_infos(self) -> dict[str, NDArray[Any]]:
        """Returns the single environment's infos of a reset by key, as new arrays."""

    def observe(self) -> Array:
        """Returns a new array of observations."""

    def get_state(self) -> dict[str, Array]:
        """Returns copies of what a saved state has beside the physics, one row per environment."""

    def set_state(self, indices: Indices, state: States) -> None:
        """Restores saved rows in some environments, after physics. Derived values may be absent."""


class Stateless:
    """Rules that keep nothing between steps. Rules that do override these methods."""

    def on_reset(self, indices: Indices) -> None:
        """Nothing to do."""

    def pre_step(self) -> None:
        """Nothing to store."""

    def reset_infos(self) -> dict[str, NDArray[Any]]:
        """Nothing."""
        return {}

    def get_state(self) -> dict[str, Array]:
        """Nothing beside the physics."""
        return {}

    def set_state(self, indices: Indices, state: States) -> None:
        """Nothing beside the physics."""


class RulesFactory(Protocol):
    """The rules of a body, and what they read of physics."""

    needs_contact_forces: bool
    """Whether they read the results of mj_rnePostConstraint."""
    fields: tuple[str, ...]
    """Derived fields of MjData that they read."""

    def __call__(self, physics: Physics, templates: Sequence[Template]) -> Rules:
        """Returns the rules over the environments with these templates."""
