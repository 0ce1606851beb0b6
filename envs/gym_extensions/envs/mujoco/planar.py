"""Hopper, Walker2d and HalfCheetah, as in Gymnasium's hopper_v5, walker2d_v5 and half_cheetah_v5."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.bodies import Health
from gym_extensions.envs.interfaces import Array, Flags, Generators, Indices, Physics, Template
from gym_extensions.envs.mujoco.base import Rules, uniform_rows


class PlanarRules(Rules):
    """Forward speed, a bonus while healthy, and a cost on the agent's action: Hopper and Walker2d."""

    def __init__(self, physics: Physics, templates: Sequence[Template]) -> None:
        super().__init__(physics, templates)
        self._x, self._z, self._rest_z = self._qpos[:, 0], self._qpos[:, 1], self._rest_qpos[:, 1]
        self._dt = templates[0].dt
        self._x_before = self._x.copy()

    def pre_step(self) -> None:
        self._x_before[:] = self._x

    def reward_and_termination(self, actions: NDArray[Any], ctrl: NDArray[Any]) -> tuple[Array, Flags]:
        """Speed + 1 while healthy − cost. The cost keeps the action's own precision, as Gymnasium's does."""
        speed = (self._x - self._x_before) / self._dt
        cost = self._body.ctrl_cost * np.square(actions).sum(axis=1)
        # The weight of speed is 1: speed and its reward are one array.
        self._terms = {"x_velocity": speed, "reward_forward": speed, "reward_ctrl": -cost}
        if self._body.health is None:
            return speed - cost, np.zeros(len(speed), np.bool_)
        healthy = self._is_healthy(self._body.health)
        self._terms["reward_survive"] = healthy.astype(np.float64)
        return speed + healthy - cost, ~healthy

    def reset_infos(self) -> dict[str, NDArray[Any]]:
        """x of the root, and the height above the rest pose if episodes end by it, m."""
        height = {} if self._body.health is None else {"z_distance_from_origin": self._z - self._rest_z}
        return {"x_position": self._x.copy()} | height

    def _is_healthy(self, health: Health) -> Flags:
        height, angle = self._z, self._qpos[:, 2]
        healthy: Flags = (height > health.height[0]) & (height < health.height[1])
        healthy &= (angle > health.angle[0]) & (angle < health.angle[1])
        if health.state is not None:
            for values in (self._qpos[:, 2:], self._qvel):
                # One test of the whole array is enough as long as every environment is healthy.
                if not np.abs(values).max() < health.state:
                    healthy &= (np.abs(values) < health.state).all(axis=1)
        return healthy

    def observe(self) -> Array:
        """Positions without x, then velocities, clipped to the body's limit."""
        velocities, limit = self._qvel, self._body.velocity_limit
        if limit is not None:
            velocities = np.minimum(np.maximum(velocities, -limit), limit)
        return np.concatenate((self._qpos[:, 1:], velocities), axis=1)


class HalfCheetahRules(PlanarRules):
    """HalfCheetah, with uniform noise on positions and normal noise on velocities."""

    def draw(self, indices: Indices, generators: Generators) -> dict[str, Array]:
        noise, nv = self._body.noise, self._qvel.shape[1]
        qpos = uniform_rows(generators, noise, self._qpos.shape[1])
        qvel = noise * np.array([generator.standard_normal(nv) for generator in generators])
        return {"qpos": self._rest_qpos[indices] + qpos, "qvel": self._rest_qvel[indices] + qvel}
