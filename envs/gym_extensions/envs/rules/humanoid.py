"""Humanoid, upright or lying down, on arrays (Gymnasium's humanoid_v5 and humanoidstandup_v5)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from gym_extensions.envs.mujoco.humanoid import contact_cost
from gym_extensions.envs.protocols import Array, Flags, Generators, Indices, Physics, States, Template
from gym_extensions.envs.rules.base import Stateless
from gym_extensions.envs.rules.noise import uniform_state
from gym_extensions.envs.state import DERIVED

NOISE = 1e-2
FORWARD_WEIGHT, CTRL_COST = 1.25, 0.1
HEALTHY_REWARD, FALLEN_REWARD = 5.0, 1.0
HEALTHY_HEIGHT = (1.0, 2.0)


class HumanoidStandupRules(Stateless):
    """HumanoidStandup's reward on height, with costs of control and contact.

    Episodes never terminate. A wall is not part of the agent.
    """

    needs_contact_forces: ClassVar[bool] = True
    fields: ClassVar[tuple[str, ...]] = ("xipos", "cinert", "cvel", "qfrc_actuator", "cfrc_ext")

    def __init__(self, physics: Physics, templates: Sequence[Template]) -> None:
        self._field = {name: physics.field(name) for name in ("qpos", "qvel", *self.fields)}
        self._qpos = np.array([template.init_qpos for template in templates])
        self._qvel = np.array([template.init_qvel for template in templates])
        self._bodies = int(templates[0].model.nbody - templates[0].model.nmocap)
        self._timestep = float(templates[0].model.opt.timestep)

    def draw(self, indices: Indices, generators: Generators) -> dict[str, Array]:
        """Positions, then velocities, around the rest pose."""
        qpos, qvel = uniform_state(generators, NOISE, self._qpos.shape[1], self._qvel.shape[1])
        return {"qpos": self._qpos[indices] + qpos, "qvel": self._qvel[indices] + qvel}

    def reward_and_termination(self, actions: NDArray[Any], ctrl: NDArray[Any]) -> tuple[Array, Flags]:
        """z / timestep − costs + 1."""
        upward = self._field["qpos"][:, 2] / self._timestep
        reward = upward - control_cost(ctrl) - self._contact_cost() + 1
        return reward, np.zeros(len(reward), np.bool_)

    def _contact_cost(self) -> Array:
        return contact_cost(self._field["cfrc_ext"][:, : self._bodies])

    def observe(self) -> Array:
        """Positions without x and y, velocities, then inertias, velocities and forces of bodies."""
        field = self._field
        num_envs, agent = len(field["qpos"]), slice(1, self._bodies)
        return np.concatenate(
            (
                field["qpos"][:, 2:],
                field["qvel"],
                field["cinert"][:, agent].reshape(num_envs, -1),
                field["cvel"][:, agent].reshape(num_envs, -1),
                field["qfrc_actuator"][:, 6:],
                field["cfrc_ext"][:, agent].reshape(num_envs, -1),
            ),
            axis=1,
        )


class HumanoidRules(HumanoidStandupRules):
    """Humanoid's reward on the speed of the center of mass, with a bonus while upright.

    A fall ends the episode.

    Speed starts from the center of mass that the previous step left, which is one evaluation old.
    """

    def __init__(self, physics: Physics, templates: Sequence[Template]) -> None:
        super().__init__(physics, templates)
        self._masses = np.array([template.model.body_mass for template in templates])
        self._total_mass = np.array([template.model.body_mass.sum() for template in templates])
        self._dt = templates[0].dt
        self._x_before = np.zeros(len(templates))

    def pre_step(self) -> None:
        """Stores the center of mass."""
        self._x_before = self._center()

    def _center(self) -> Array:
        """x of the center of mass in every environment, m."""
        weighted: Array = np.einsum("lb,lb->l", self._masses, self._field["xipos"][:, :, 0])
        center: Array = weighted / self._total_mass
        return center

    def _forward(self) -> Array:
        return FORWARD_WEIGHT * ((self._center() - self._x_before) / self._dt)

    def _healthy(self) -> Flags:
        height = self._field["qpos"][:, 2]
        healthy: Flags = (height > HEALTHY_HEIGHT[0]) & (height < HEALTHY_HEIGHT[1])
        return healthy

    def reward_and_termination(self, actions: NDArray[Any], ctrl: NDArray[Any]) -> tuple[Array, Flags]:
        """1.25 × speed + 5 while upright − costs."""
        healthy = self._healthy()
        gains = self._forward() + healthy * HEALTHY_REWARD
        return gains - (control_cost(ctrl) + self._contact_cost()), ~healthy

    def get_state(self) -> dict[str, Array]:
        """The bodies' centers after the last step, from which the next reward starts."""
        return {DERIVED + "xipos": self._field["xipos"].copy()}

    def set_state(self, indices: Indices, state: States) -> None:
        """Restores saved centers. Without them, the first reward starts from recomputed centers."""
        if DERIVED + "xipos" in state:
            self._field["xipos"][indices] = state[DERIVED + "xipos"]


class HumanoidStandupAndRunRules(HumanoidRules):
    """HumanoidStandupAndRun's reward on speed and height, with a smaller bonus at unhealthy heights.

    Episodes never terminate.
    """

    def reward_and_termination(self, actions: NDArray[Any], ctrl: NDArray[Any]) -> tuple[Array, Flags]:
        """1.25 × speed + z / timestep + (5 if healthy else 1) − costs."""
        upward = self._field["qpos"][:, 2] / self._timestep
        bonus = np.where(self._healthy(), HEALTHY_REWARD, FALLEN_REWARD)
        reward = self._forward() + upward + bonus - control_cost(ctrl) - self._contact_cost()
        return reward, np.zeros(len(reward), np.bool_)


def control_cost(ctrl: NDArray[Any]) -> Array:
    """0.1 × Σ ctrl², squared in float64 as in mjData."""
    squares: Array = np.square(ctrl.astype(np.float64)).sum(axis=1)
    return CTRL_COST * squares
