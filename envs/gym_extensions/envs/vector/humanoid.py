"""Humanoid, lying down or upright, on whole arrays (Gymnasium's humanoid_v5 and humanoidstandup_v5)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from gym_extensions.envs.mujoco.humanoid import contact_cost
from gym_extensions.envs.state import DERIVED
from gym_extensions.envs.vector.noise import uniform_state
from gym_extensions.envs.vector.physics import Array, Lanes, Physics
from gym_extensions.envs.vector.rules import Flags
from gym_extensions.envs.vector.template import Prototype

NOISE = 1e-2
FORWARD_WEIGHT, CTRL_COST = 1.25, 0.1
HEALTHY_REWARD, FALLEN_REWARD = 5.0, 1.0
HEALTHY_HEIGHT = (1.0, 2.0)


class LyingDown:
    """HumanoidStandup: height, costs on control and contact; never ends. A wall is no part of the agent."""

    pooled: ClassVar[bool] = True
    fields: ClassVar[tuple[str, ...]] = ("xipos", "cinert", "cvel", "qfrc_actuator", "cfrc_ext")

    def __init__(self, physics: Physics, lanes: Sequence[Prototype]) -> None:
        self._field = {name: physics.field(name) for name in ("qpos", "qvel", *self.fields)}
        self._qpos = np.array([lane.init_qpos for lane in lanes])
        self._qvel = np.array([lane.init_qvel for lane in lanes])
        self._bodies = int(lanes[0].model.nbody - lanes[0].model.nmocap)
        self._timestep = float(lanes[0].model.opt.timestep)

    def draw(self, lanes: Lanes, generators: Sequence[np.random.Generator]) -> dict[str, Array]:
        """Positions, then velocities, about the model's own."""
        qpos, qvel = uniform_state(generators, NOISE, self._qpos.shape[1], self._qvel.shape[1])
        return {"qpos": self._qpos[lanes] + qpos, "qvel": self._qvel[lanes] + qvel}

    def started(self, lanes: Lanes) -> None:
        """Nothing is carried."""

    def before(self) -> None:
        """The reward compares with nothing."""

    def outcome(self, actions: NDArray[Any], ctrl: NDArray[Any]) -> tuple[Array, Flags]:
        """z / timestep − costs + 1."""
        upward = self._field["qpos"][:, 2] / self._timestep
        reward = upward - control_cost(ctrl) - self._contact_cost() + 1
        return reward, np.zeros(len(reward), np.bool_)

    def _contact_cost(self) -> Array:
        return contact_cost(self._field["cfrc_ext"][:, : self._bodies])

    def observe(self) -> Array:
        """Positions but x and y, velocities, then the agent's bodies' inertias, velocities and forces."""
        field = self._field
        lanes, agent = len(field["qpos"]), slice(1, self._bodies)
        return np.concatenate(
            (
                field["qpos"][:, 2:],
                field["qvel"],
                field["cinert"][:, agent].reshape(lanes, -1),
                field["cvel"][:, agent].reshape(lanes, -1),
                field["qfrc_actuator"][:, 6:],
                field["cfrc_ext"][:, agent].reshape(lanes, -1),
            ),
            axis=1,
        )

    def carried(self) -> dict[str, Array]:
        """Nothing beside the physics."""
        return {}

    def carry(self, lanes: Lanes, state: Mapping[str, Array]) -> None:
        """Nothing beside the physics."""


class Upright(LyingDown):
    """Humanoid: speed of the centre of mass, a bonus while upright, the same costs; ends when it falls.

    Speed starts from the centre of mass as the step before left it, which lags by one evaluation.
    """

    def __init__(self, physics: Physics, lanes: Sequence[Prototype]) -> None:
        super().__init__(physics, lanes)
        self._masses = np.array([lane.model.body_mass for lane in lanes])
        self._total_mass = np.array([lane.model.body_mass.sum() for lane in lanes])
        self._dt = lanes[0].dt
        self._x_before = np.zeros(len(lanes))

    def before(self) -> None:
        """Keeps the centre of mass."""
        self._x_before = self._centre()

    def _centre(self) -> Array:
        """x of the centre of mass in every lane, m."""
        weighted: Array = np.einsum("lb,lb->l", self._masses, self._field["xipos"][:, :, 0])
        centre: Array = weighted / self._total_mass
        return centre

    def _forward(self) -> Array:
        return FORWARD_WEIGHT * ((self._centre() - self._x_before) / self._dt)

    def _healthy(self) -> Flags:
        height = self._field["qpos"][:, 2]
        healthy: Flags = (height > HEALTHY_HEIGHT[0]) & (height < HEALTHY_HEIGHT[1])
        return healthy

    def outcome(self, actions: NDArray[Any], ctrl: NDArray[Any]) -> tuple[Array, Flags]:
        """1.25 × speed + 5 while upright − costs."""
        healthy = self._healthy()
        gains = self._forward() + healthy * HEALTHY_REWARD
        return gains - (control_cost(ctrl) + self._contact_cost()), ~healthy

    def carried(self) -> dict[str, Array]:
        """The bodies' centres as the last step left them: the next reward starts from those."""
        return {DERIVED + "xipos": self._field["xipos"].copy()}

    def carry(self, lanes: Lanes, state: Mapping[str, Array]) -> None:
        """Puts saved centres back; without them the first reward starts from the recomputed ones."""
        if DERIVED + "xipos" in state:
            self._field["xipos"][lanes] = state[DERIVED + "xipos"]


class StandingUpToRun(Upright):
    """HumanoidStandupAndRun: speed, height, a smaller bonus outside of healthy heights; never ends."""

    def outcome(self, actions: NDArray[Any], ctrl: NDArray[Any]) -> tuple[Array, Flags]:
        """1.25 × speed + z / timestep + (5 if healthy else 1) − costs."""
        upward = self._field["qpos"][:, 2] / self._timestep
        bonus = np.where(self._healthy(), HEALTHY_REWARD, FALLEN_REWARD)
        reward = self._forward() + upward + bonus - control_cost(ctrl) - self._contact_cost()
        return reward, np.zeros(len(reward), np.bool_)


def control_cost(ctrl: NDArray[Any]) -> Array:
    """.1 × Σ ctrl², squared in float64 as mjData holds it."""
    squares: Array = np.square(ctrl.astype(np.float64)).sum(axis=1)
    return CTRL_COST * squares
