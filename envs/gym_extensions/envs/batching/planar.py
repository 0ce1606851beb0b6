"""Hopper, Walker2d and HalfCheetah on whole arrays (Gymnasium's hopper_v5, walker2d_v5, half_cheetah_v5)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from gym_extensions.envs.batching.physics import Array, Lanes, Physics
from gym_extensions.envs.batching.prototype import Prototype
from gym_extensions.envs.batching.rules import Flags

VELOCITY_LIMIT = 10.0
"""Hopper's and Walker2d's observed velocities are clipped to ± this."""


@dataclass(frozen=True)
class Health:
    """Open intervals outside of which an episode ends."""

    height: tuple[float, float]
    angle: tuple[float, float]
    state: tuple[float, float] | None = None


@dataclass(frozen=True)
class PlanarRow:
    """The numbers in which the planar bodies differ; ``health`` None never ends an episode."""

    ctrl_cost: float
    noise: float
    health: Health | None
    normal_velocities: bool = False


ROWS = {
    "Hopper": PlanarRow(1e-3, 5e-3, Health((0.7, np.inf), (-0.2, 0.2), (-100.0, 100.0))),
    "Walker2d": PlanarRow(1e-3, 5e-3, Health((0.8, 2.0), (-1.0, 1.0))),
    "HalfCheetah": PlanarRow(0.1, 0.1, None, normal_velocities=True),
}


class Planar:
    """Forward speed, a bonus while healthy, and a cost on the action as given."""

    pooled: ClassVar[bool] = False
    fields: ClassVar[tuple[str, ...]] = ()

    def __init__(self, physics: Physics, lanes: Sequence[Prototype]) -> None:
        self._row = ROWS[lanes[0].task.base]
        self._prototypes = lanes
        self._qpos, self._qvel = physics.field("qpos"), physics.field("qvel")
        self._dt = lanes[0].dt
        self._x_before = self._qpos[:, 0].copy()

    def draw(self, lane: int, generator: np.random.Generator) -> Mapping[str, Array]:
        """Positions, then velocities, about the model's own."""
        start, noise = self._prototypes[lane], self._row.noise
        qpos = start.init_qpos + generator.uniform(-noise, noise, start.model.nq)
        if self._row.normal_velocities:
            return {"qpos": qpos, "qvel": start.init_qvel + noise * generator.standard_normal(start.model.nv)}
        return {"qpos": qpos, "qvel": start.init_qvel + generator.uniform(-noise, noise, start.model.nv)}

    def started(self, lanes: Lanes) -> None:
        """Nothing is carried from step to step."""

    def before(self) -> None:
        """Keeps the root's x."""
        self._x_before[:] = self._qpos[:, 0]

    def outcome(self, actions: NDArray[Any]) -> tuple[Array, Flags]:
        """Speed + 1 while healthy − cost; the cost keeps the action's own precision, as Gymnasium's does."""
        reward = (self._qpos[:, 0] - self._x_before) / self._dt
        cost = self._row.ctrl_cost * np.square(actions).sum(axis=1)
        if self._row.health is None:
            return reward - cost, np.zeros(len(reward), np.bool_)
        healthy = self._healthy(self._row.health)
        reward += healthy
        reward -= cost
        return reward, ~healthy

    def _healthy(self, health: Health) -> Flags:
        height, angle = self._qpos[:, 1], self._qpos[:, 2]
        healthy = (height > health.height[0]) & (height < health.height[1])
        healthy &= (angle > health.angle[0]) & (angle < health.angle[1])
        if health.state is not None:
            low, high = health.state
            positions, velocities = self._qpos[:, 2:], self._qvel
            healthy &= ((positions > low) & (positions < high)).all(axis=1)
            healthy &= ((velocities > low) & (velocities < high)).all(axis=1)
        return healthy

    def observe(self) -> Array:
        """Positions without x, then velocities, clipped for the bodies that can fall."""
        shown = self._qpos.shape[1] - 1
        observations = np.empty((len(self._qpos), shown + self._qvel.shape[1]))
        observations[:, :shown] = self._qpos[:, 1:]
        if self._row.health is None:
            observations[:, shown:] = self._qvel
        else:
            np.clip(self._qvel, -VELOCITY_LIMIT, VELOCITY_LIMIT, out=observations[:, shown:])
        return observations

    def carried(self) -> dict[str, Array]:
        """Nothing beside the physics."""
        return {}

    def carry(self, lanes: Lanes, state: Mapping[str, Array]) -> None:
        """Nothing beside the physics."""
