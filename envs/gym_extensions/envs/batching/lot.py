"""Lanes that share a model layout and rules: one physics batch, one set of whole-array rules."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from gym_extensions.envs.batching.families import family
from gym_extensions.envs.batching.physics import Array, BatchPhysics, Lanes, Physics
from gym_extensions.envs.batching.pool import PooledPhysics
from gym_extensions.envs.batching.prototype import Prototype
from gym_extensions.envs.batching.rules import Flags

LAYOUT = (
    *("nq", "nv", "nu", "na", "nbody", "njnt", "ngeom", "nsite", "ncam", "nlight", "nmesh", "nmocap"),
    *("neq", "ntendon", "nsensor", "nsensordata", "nuserdata", "nplugin"),
)
"""Sizes of MjModel that simulations in one batch have in common."""


def layout(lane: Prototype) -> tuple[object, ...]:
    """What two lanes must share to be stepped by one batch: rules and the sizes of everything simulated."""
    sizes = tuple(int(getattr(lane.model, name)) for name in LAYOUT)
    return (lane.task.base, family(lane.task), lane.frame_skip, lane.model.opt.timestep, sizes)


def physics(lanes: Sequence[Prototype], num_threads: int) -> Physics:
    """The simulations of the lanes' models, on the engine that their rules need."""
    rules = family(lanes[0].task)
    models: list[mujoco.MjModel] = [lane.model for lane in lanes]
    engine = PooledPhysics if rules.pooled else BatchPhysics
    return engine(models, lanes[0].frame_skip, num_threads, rules.fields)


class Lot:
    """Lanes of one layout. ``places`` are their indices in the vector environment."""

    def __init__(self, places: Lanes, lanes: Sequence[Prototype], num_threads: int) -> None:
        self.places = places
        self._physics = physics(lanes, num_threads)
        self._rules = family(lanes[0].task)(self._physics, lanes)

    def reset(self, lanes: Lanes, generators: Sequence[np.random.Generator]) -> None:
        """Starts new episodes in some lanes, each drawn from its own generator."""
        self._physics.reset(lanes, self._rules.draw(lanes, generators))
        self._rules.started(lanes)

    def step(self, actions: NDArray[Any], lanes: Lanes | None) -> tuple[Array, Flags]:
        """Rewards and terminations of one step in the given lanes, or in all."""
        self._rules.before()
        self._physics.step(actions, lanes)
        return self._rules.outcome(actions)

    def observe(self) -> Array:
        """A new array of every lane's observation."""
        return self._rules.observe()

    def save(self) -> dict[str, Array]:
        """Copies of every lane's state by name, ``(lanes, …)``."""
        return self._physics.snapshot() | self._rules.carried()

    def load(self, lanes: Lanes, state: Mapping[str, Array]) -> None:
        """Puts saved rows back into some lanes."""
        self._physics.load(lanes, state)
        self._rules.carry(lanes, state)

    def close(self) -> None:
        """Lets threads and memory go."""
        self._physics.close()
