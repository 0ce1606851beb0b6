"""The humanoids that run, stand up, or both, as in Gymnasium's humanoid_v5 and humanoidstandup_v5."""

from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from gym_extensions.envs.interfaces import Array, Flags, Physics, Template
from gym_extensions.envs.mujoco.base import Rules

CONTACT_WEIGHT, MAX_CONTACT_COST = 5e-7, 10.0
FORWARD_WEIGHT, HEALTHY_REWARD, FALLEN_REWARD = 1.25, 5.0, 1.0


class HumanoidStandupRules(Rules):
    """HumanoidStandup's reward on height, with costs of control and contact.

    Episodes never terminate. A wall is not part of the agent.
    """

    needs_contact_forces: ClassVar[bool] = True
    fields: ClassVar[tuple[str, ...]] = (
        *("xipos", "cinert", "cvel", "qfrc_actuator", "cfrc_ext"),
        *("ten_length", "ten_velocity"),
    )

    def __init__(self, physics: Physics, templates: Sequence[Template]) -> None:
        super().__init__(physics, templates)
        self._field = {name: physics.field(name) for name in self.fields}
        self._bodies = int(templates[0].model.nbody - templates[0].model.nmocap)
        self._timestep = float(templates[0].model.opt.timestep)

    def reward_and_termination(self, actions: NDArray[Any], ctrl: NDArray[Any]) -> tuple[Array, Flags]:
        """z / timestep − costs + 1."""
        upward = self._qpos[:, 2] / self._timestep
        control, impact = self._control_cost(ctrl), self._contact_cost()
        self._terms = {"reward_linup": upward, "reward_quadctrl": -control, "reward_impact": -impact}
        return upward - control - impact + 1, np.zeros(len(upward), np.bool_)

    def reset_infos(self) -> dict[str, NDArray[Any]]:
        """Position of the torso and height above the rest pose, m; lengths and velocities of tendons."""
        height = self._qpos[:, 2] - self._rest_qpos[:, 2]
        return self._placement() | {"z_distance_from_origin": height}

    def _placement(self) -> dict[str, NDArray[Any]]:
        x, y = self._qpos[:, 0].copy(), self._qpos[:, 1].copy()
        length, velocity = self._field["ten_length"].copy(), self._field["ten_velocity"].copy()
        return {"x_position": x, "y_position": y, "tendon_length": length, "tendon_velocity": velocity}

    def _contact_cost(self) -> Array:
        """The cost of the contact forces, in [0, 10] (Gymnasium's humanoid_v5)."""
        forces = self._field["cfrc_ext"][:, : self._bodies]
        squares = np.square(forces.reshape(len(forces), -1)).sum(axis=-1)
        return np.minimum(CONTACT_WEIGHT * squares, MAX_CONTACT_COST)

    def _control_cost(self, ctrl: NDArray[Any]) -> Array:
        """The weight × Σ ctrl², squared in float64 as in mjData."""
        squares: Array = np.square(ctrl.astype(np.float64)).sum(axis=1)
        return self._body.ctrl_cost * squares

    def observe(self) -> Array:
        """Positions without x and y, velocities, then inertias, velocities and forces of bodies."""
        field, num_envs = self._field, len(self._qpos)
        inertia, speed, force = (
            field[name][:, 1 : self._bodies].reshape(num_envs, -1) for name in ("cinert", "cvel", "cfrc_ext")
        )
        motors = field["qfrc_actuator"][:, 6:]
        return np.concatenate((self._qpos[:, 2:], self._qvel, inertia, speed, motors, force), axis=1)


class HumanoidRules(HumanoidStandupRules):
    """Humanoid's reward on the speed of the center of mass, with a bonus while upright; a fall is the end.

    Speed starts from the center of mass that the previous step left, which is one evaluation old.
    """

    def __init__(self, physics: Physics, templates: Sequence[Template]) -> None:
        super().__init__(physics, templates)
        self._masses = np.array([template.model.body_mass for template in templates])
        self._total_mass = np.array([template.model.body_mass.sum() for template in templates])
        self._dt = templates[0].dt
        self._before = np.zeros((2, len(templates)))
        self._velocity = np.zeros((2, len(templates)))

    def pre_step(self) -> None:
        self._before = self._center()

    def _center(self) -> Array:
        """x and y of the center of mass in every environment, m, (2, num_envs)."""
        positions = self._field["xipos"]
        weighted = [np.einsum("lb,lb->l", self._masses, positions[:, :, axis]) for axis in (0, 1)]
        return np.array(weighted) / self._total_mass

    def _healthy(self) -> Flags:
        height, health = self._qpos[:, 2], self._body.health
        assert health is not None
        return (height > health.height[0]) & (height < health.height[1])

    def _start_terms(self, survive: Array, ctrl: NDArray[Any]) -> dict[str, Array]:
        """Stores and returns the terms of the reward that all humanoids on their feet have."""
        self._velocity = (self._center() - self._before) / self._dt
        self._terms = {
            "reward_survive": survive,
            "reward_forward": FORWARD_WEIGHT * self._velocity[0],
            "reward_ctrl": -self._control_cost(ctrl),
            "reward_contact": -self._contact_cost(),
        }
        return self._terms

    def reward_and_termination(self, actions: NDArray[Any], ctrl: NDArray[Any]) -> tuple[Array, Flags]:
        """1.25 × speed + 5 while upright − costs."""
        healthy = self._healthy()
        terms = self._start_terms(np.where(healthy, HEALTHY_REWARD, 0.0), ctrl)
        gains = terms["reward_forward"] + terms["reward_survive"]
        return gains + (terms["reward_ctrl"] + terms["reward_contact"]), ~healthy

    def step_infos(self) -> dict[str, NDArray[Any]]:
        """Also the velocities of the center of mass, m/s."""
        x_velocity, y_velocity = self._velocity
        return self.reset_infos() | {"x_velocity": x_velocity, "y_velocity": y_velocity} | self._terms

    def reset_infos(self) -> dict[str, NDArray[Any]]:
        """Position of the torso and distance from the origin, m; lengths and velocities of tendons."""
        position = self._qpos[:, :2]
        return self._placement() | {"distance_from_origin": np.sqrt(np.square(position).sum(axis=1))}


class HumanoidStandupAndRunRules(HumanoidRules):
    """HumanoidStandupAndRun's reward on speed and height, with a smaller bonus at unhealthy heights.

    Episodes never terminate.
    """

    def reward_and_termination(self, actions: NDArray[Any], ctrl: NDArray[Any]) -> tuple[Array, Flags]:
        """1.25 × speed + z / timestep + (5 if healthy else 1) − costs."""
        bonus = np.where(self._healthy(), HEALTHY_REWARD, FALLEN_REWARD)
        terms = self._start_terms(bonus, ctrl)
        terms["reward_linup"] = self._qpos[:, 2] / self._timestep
        gains = terms["reward_forward"] + terms["reward_linup"] + terms["reward_survive"]
        return gains + terms["reward_ctrl"] + terms["reward_contact"], np.zeros(len(gains), np.bool_)
