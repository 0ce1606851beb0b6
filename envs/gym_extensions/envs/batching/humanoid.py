"""Humanoid on whole arrays (Gymnasium's humanoid_v5)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from gym_extensions.envs.batching.noise import uniform_state
from gym_extensions.envs.batching.physics import Array, Lanes, Physics
from gym_extensions.envs.batching.prototype import Prototype
from gym_extensions.envs.batching.rules import Flags
from gym_extensions.envs.state import DERIVED

NOISE = 1e-2
FORWARD_WEIGHT, CTRL_COST, CONTACT_COST, MOST_CONTACT_COST = 1.25, 0.1, 5e-7, 10.0
HEALTHY_REWARD, HEALTHY_HEIGHT = 5.0, (1.0, 2.0)


def _control_cost(actions: NDArray[Any]) -> Array:
    squares: Array = np.square(actions.astype(np.float64)).sum(axis=1)
    return CTRL_COST * squares


class HumanoidRules:
    """Speed of the centre of mass, a bonus while upright, costs on control and contact."""

    pooled: ClassVar[bool] = True
    fields: ClassVar[tuple[str, ...]] = ("xipos", "cinert", "cvel", "qfrc_actuator", "cfrc_ext")

    def __init__(self, physics: Physics, lanes: Sequence[Prototype]) -> None:
        self._qpos = np.array([lane.init_qpos for lane in lanes])
        self._qvel = np.array([lane.init_qvel for lane in lanes])
        self._field = {name: physics.field(name) for name in ("qpos", "qvel", *self.fields)}
        self._masses = np.array([lane.model.body_mass for lane in lanes])
        self._total_mass = np.array([lane.model.body_mass.sum() for lane in lanes])
        self._dt = lanes[0].dt
        self._x_before = np.zeros(len(lanes))

    def draw(self, lanes: Lanes, generators: Sequence[np.random.Generator]) -> Mapping[str, Array]:
        """Positions, then velocities, about the model's own."""
        qpos, qvel = uniform_state(generators, NOISE, self._qpos.shape[1], self._qvel.shape[1])
        return {"qpos": self._qpos[lanes] + qpos, "qvel": self._qvel[lanes] + qvel}

    def started(self, lanes: Lanes) -> None:
        """The centre of mass is read from the bodies, so nothing is carried."""

    def before(self) -> None:
        """Keeps the centre of mass, which lags the positions by one evaluation as in Gymnasium."""
        self._x_before = self._centre()

    def _centre(self) -> Array:
        """x of the centre of mass in every lane, m."""
        weighted: Array = np.einsum("lb,lb->l", self._masses, self._field["xipos"][:, :, 0])
        centre: Array = weighted / self._total_mass
        return centre

    def outcome(self, actions: NDArray[Any]) -> tuple[Array, Flags]:
        """1.25 × speed + 5 while upright − costs; the action is squared in float64, as mjData holds it."""
        speed = (self._centre() - self._x_before) / self._dt
        height = self._field["qpos"][:, 2]
        healthy = (height > HEALTHY_HEIGHT[0]) & (height < HEALTHY_HEIGHT[1])
        costs = _control_cost(actions) + self._contact_cost()
        return (FORWARD_WEIGHT * speed + healthy * HEALTHY_REWARD) - costs, ~healthy

    def _contact_cost(self) -> Array:
        forces = self._field["cfrc_ext"]
        squares: Array = np.square(forces).reshape(len(forces), -1).sum(axis=1)
        return np.minimum(CONTACT_COST * squares, MOST_CONTACT_COST)

    def observe(self) -> Array:
        """Positions without x and y, velocities, the bodies' inertias, velocities, forces but the world's."""
        field = self._field
        lanes = len(field["qpos"])
        return np.concatenate(
            (
                field["qpos"][:, 2:],
                field["qvel"],
                field["cinert"][:, 1:].reshape(lanes, -1),
                field["cvel"][:, 1:].reshape(lanes, -1),
                field["qfrc_actuator"][:, 6:],
                field["cfrc_ext"][:, 1:].reshape(lanes, -1),
            ),
            axis=1,
        )

    def carried(self) -> dict[str, Array]:
        """The bodies' centres as the last step left them: the next reward starts from those."""
        return {DERIVED + "xipos": self._field["xipos"].copy()}

    def carry(self, lanes: Lanes, state: Mapping[str, Array]) -> None:
        """Puts saved centres back; without them the first reward starts from the recomputed ones."""
        if DERIVED + "xipos" in state:
            self._field["xipos"][lanes] = state[DERIVED + "xipos"]
