"""Lanes that share a model layout, rules and parts: one physics batch, everything else on whole arrays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from gym_extensions.envs.vector.physics import Array, BatchPhysics, Lanes, Physics
from gym_extensions.envs.vector.registry import FAMILIES, parts
from gym_extensions.envs.vector.rules import Flags
from gym_extensions.envs.vector.template import Prototype
from gym_extensions.envs.vector.thread_pool import PooledPhysics


def physics(lanes: Sequence[Prototype], num_threads: int) -> Physics:
    """The simulations of the lanes' models, on the engine that their rules need."""
    rules = FAMILIES[lanes[0].task.base]
    models: list[mujoco.MjModel] = [lane.model for lane in lanes]
    engine = PooledPhysics if rules.pooled else BatchPhysics
    return engine(models, lanes[0].frame_skip, num_threads, rules.fields)


class Lot:
    """Lanes of one layout. ``places`` are their indices in the vector environment."""

    def __init__(self, places: Lanes, lanes: Sequence[Prototype], num_threads: int) -> None:
        self.places = places
        self._dt = lanes[0].dt
        self._steps = np.zeros(len(lanes), np.int64)
        self._physics = physics(lanes, num_threads)
        self._rules = FAMILIES[lanes[0].task.base](self._physics, lanes)
        self._parts = parts(self._physics, lanes)

    def reset(self, lanes: Lanes, generators: Sequence[np.random.Generator]) -> None:
        """Starts new episodes in some lanes, each drawn from its own generator: body first, then parts."""
        rows = self._rules.draw(lanes, generators)
        for part in self._parts:
            part.draw(lanes, generators, rows)
        self._physics.reset(lanes, rows)
        self._steps[lanes] = 0
        self._rules.started(lanes)
        for part in self._parts:
            part.started(lanes)

    def step(self, actions: NDArray[Any], lanes: Lanes | None) -> tuple[Array, Flags]:
        """Rewards and terminations of one step in the given lanes, or in all."""
        self._rules.before()
        ctrl = actions
        for part in self._parts:
            part.before(self._steps)
            ctrl = part.applied(ctrl, self._steps)
        self._physics.step(ctrl, lanes)
        self._steps += 1
        return self._rules.outcome(actions, ctrl)

    def observe(self) -> Array:
        """A new array of every lane's observation."""
        appended = [seen for part in self._parts if (seen := part.observed()) is not None]
        observations = self._rules.observe()
        return np.concatenate((observations, *appended), axis=1) if appended else observations

    def save(self) -> dict[str, Array]:
        """Copies of every lane's state by name, ``(lanes, …)``."""
        saved = self._physics.snapshot() | self._rules.carried()
        for part in self._parts:
            saved |= part.carried()
        return saved

    def load(self, lanes: Lanes, state: Mapping[str, Array]) -> None:
        """Puts saved rows back into some lanes."""
        self._physics.load(lanes, state)
        self._steps[lanes] = np.rint(np.asarray(state["time"]) / self._dt).astype(np.int64)
        self._rules.carry(lanes, state)
        for part in self._parts:
            part.carry(lanes, state)

    def close(self) -> None:
        """Lets threads and memory go."""
        self._physics.close()
