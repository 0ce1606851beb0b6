"""The moments at which an environment calls the effects of its run-time variations."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.task import Task
from gym_extensions.envs.protocols import (
    Array,
    Generators,
    Indices,
    Physics,
    Simulation,
    States,
    Steps,
    Template,
)
from gym_extensions.envs.state import State

Kind = TypeVar("Kind")


class Effect:
    """The effect on one environment. The methods do nothing; an effect overrides those it needs."""

    def on_reset(self, simulation: Simulation) -> None:
        """Draws and places after the body's own draws. Derived fields are recomputed afterwards."""

    def pre_step(self, simulation: Simulation) -> None:
        """Acts before the physics of a step."""

    def control(self, simulation: Simulation, ctrl: NDArray[Any]) -> NDArray[Any]:
        """Returns what the motors receive for a command."""
        return ctrl

    def observation(self, simulation: Simulation) -> Array:
        """Returns what the effect appends to the observation."""
        return np.zeros(0)

    def get_state(self) -> State:
        """Returns a copy of the effect's own state, by name."""
        return {}

    def set_state(self, state: Mapping[str, Array]) -> None:
        """Restores what ``get_state`` returned. Derived values may be absent."""


class VectorEffect:
    """The same effect on many environments. ``steps`` counts environment steps since each reset."""

    def draw(self, indices: Indices, generators: Generators, rows: dict[str, Array]) -> None:
        """Draws after the body, and adds to the rows of the states in which environments start."""

    def on_reset(self, indices: Indices) -> None:
        """Acts after some environments have started an episode."""

    def pre_step(self, steps: Steps) -> None:
        """Acts before the physics of a step. Rows of environments that are not stepped are ignored."""

    def control(self, ctrl: NDArray[Any], steps: Steps) -> NDArray[Any]:
        """Returns what the motors receive for commands ``(num_envs, nu)``."""
        return ctrl

    def observation(self) -> Array | None:
        """Returns what the effect appends to the observations, ``(num_envs, …)``."""
        return None

    def get_state(self) -> dict[str, Array]:
        """Returns copies of the effect's own state by name, one row per environment."""
        return {}

    def set_state(self, indices: Indices, state: States) -> None:
        """Restores saved rows in some environments. Derived values may be absent."""


@dataclass(frozen=True)
class EffectKind:
    """One row of the registry of effects.

    Args:
        variation: the class of the variation.
        single: makes the effect on one environment of a task.
        vector: makes the effect on many environments, given their physics and templates.
        draw_order: effects draw from an environment's generator in this order. The numbers of published
            kinds never change; a new kind has a larger number.
        shard_key: environments share a shard only if this value of their variations is equal.
        replaces: the variation whose effect this one replaces; a task must have it too.
    """

    variation: type
    single: Callable[[Task], Effect]
    vector: Callable[[Physics, Sequence[Template]], VectorEffect]
    draw_order: int
    shard_key: Callable[[Any], object] = repr
    replaces: type | None = None


def required(task: Task, kind: type[Kind]) -> Kind:
    """Returns the task's variation of a class. Raises ``ValueError`` if it has none."""
    variation = variation_of(task, kind)
    if variation is None:
        raise ValueError(f"{task.id} has no {kind.__name__}")
    return variation


def variation_of(task: Task, kind: type[Kind]) -> Kind | None:
    """Returns the task's variation of a class, or None."""
    return next((variation for variation in task.variations if isinstance(variation, kind)), None)
