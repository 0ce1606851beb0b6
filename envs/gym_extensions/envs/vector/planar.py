"""Hopper, Walker2d and HalfCheetah on whole arrays (Gymnasium's hopper_v5, walker2d_v5, half_cheetah_v5)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from gym_extensions.envs.vector.noise import uniform_rows, uniform_state
from gym_extensions.envs.vector.physics import Array, Lanes, Physics
from gym_extensions.envs.vector.rules import Flags
from gym_extensions.envs.vector.template import Prototype

VELOCITY_LIMIT = 10.0
"""Hopper's and Walker2d's observed velocities are clipped to ± this."""


@dataclass(frozen=True)
class Health:
    """Open intervals outside of which an episode ends; ``state`` bounds every other coordinate's size."""

    height: tuple[float, float]
    angle: tuple[float, float]
    state: float | None = None


@dataclass(frozen=True)
class PlanarRow:
    """The numbers in which the planar bodies differ; ``health`` None never ends an episode."""

    ctrl_cost: float
    noise: float
    health: Health | None
    normal_velocities: bool = False


ROWS = {
    "Hopper": PlanarRow(1e-3, 5e-3, Health((0.7, np.inf), (-0.2, 0.2), 100.0)),
    "Walker2d": PlanarRow(1e-3, 5e-3, Health((0.8, 2.0), (-1.0, 1.0))),
    "HalfCheetah": PlanarRow(0.1, 0.1, None, normal_velocities=True),
}


class Planar:
    """Forward speed, a bonus while healthy, and a cost on the action as given."""

    pooled: ClassVar[bool] = False
    fields: ClassVar[tuple[str, ...]] = ()

    def __init__(self, physics: Physics, lanes: Sequence[Prototype]) -> None:
        self._row = ROWS[lanes[0].task.base]
        self._starts = {
            "qpos": np.array([lane.init_qpos for lane in lanes]),
            "qvel": np.array([lane.init_qvel for lane in lanes]),
        }
        self._qpos, self._qvel = physics.field("qpos"), physics.field("qvel")
        self._dt = lanes[0].dt
        self._x_before = self._qpos[:, 0].copy()

    def draw(self, lanes: Lanes, generators: Sequence[np.random.Generator]) -> dict[str, Array]:
        """Positions, then velocities, about the model's own."""
        noise = self._row.noise
        if self._row.normal_velocities:
            qpos = uniform_rows(generators, noise, self._qpos.shape[1])
            qvel = noise * np.array([own.standard_normal(self._qvel.shape[1]) for own in generators])
        else:
            qpos, qvel = uniform_state(generators, noise, self._qpos.shape[1], self._qvel.shape[1])
        return {"qpos": self._starts["qpos"][lanes] + qpos, "qvel": self._starts["qvel"][lanes] + qvel}

    def started(self, lanes: Lanes) -> None:
        """Nothing is carried from step to step."""

    def before(self) -> None:
        """Keeps the root's x."""
        self._x_before[:] = self._qpos[:, 0]

    def outcome(self, actions: NDArray[Any], ctrl: NDArray[Any]) -> tuple[Array, Flags]:
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
            for part in (self._qpos[:, 2:], self._qvel):
                # One look at the whole array is enough as long as every lane is sound.
                if not np.abs(part).max() < health.state:
                    healthy &= (np.abs(part) < health.state).all(axis=1)
        return healthy

    def observe(self) -> Array:
        """Positions without x, then velocities, clipped for the bodies that can fall."""
        shown = self._qpos.shape[1] - 1
        observations = np.empty((len(self._qpos), shown + self._qvel.shape[1]))
        observations[:, :shown] = self._qpos[:, 1:]
        if self._row.health is None:
            observations[:, shown:] = self._qvel
        else:
            velocities = np.maximum(self._qvel, -VELOCITY_LIMIT)
            np.minimum(velocities, VELOCITY_LIMIT, out=observations[:, shown:])
        return observations

    def carried(self) -> dict[str, Array]:
        """Nothing beside the physics."""
        return {}

    def carry(self, lanes: Lanes, state: Mapping[str, Array]) -> None:
        """Nothing beside the physics."""
