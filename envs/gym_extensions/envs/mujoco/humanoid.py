"""Gymnasium's v5 humanoid classes for running, standing up and both, with the wall left out."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
from gymnasium.envs.mujoco.humanoid_v5 import HumanoidEnv
from gymnasium.envs.mujoco.humanoidstandup_v5 import HumanoidStandupEnv

from gym_extensions.catalog.task import Task
from gym_extensions.envs.mujoco.task_env import TaskEnv
from gym_extensions.envs.protocols import Array

CONTACT_WEIGHT, MAX_CONTACT_COST = 5e-7, 10.0


def contact_cost(forces: Array) -> Array:
    """The cost of contact forces (…, bodies, 6), in [0, 10] (Gymnasium's humanoid_v5)."""
    flat = forces.reshape(*forces.shape[:-2], -1)
    cost: Array = np.minimum(CONTACT_WEIGHT * np.square(flat).sum(axis=-1), MAX_CONTACT_COST)
    return cost


class _Agent(TaskEnv):
    """Observation and contact cost of the agent's bodies only. A wall is the last body of the model."""

    @property
    def agent_bodies(self) -> int:
        """Number of bodies, including the world and without a wall."""
        return int(self.model.nbody - self.model.nmocap)

    def body_observation(self) -> Array:
        """Positions without x and y, velocities, inertias, body velocities, motor forces, contact forces."""
        agent = slice(1, self.agent_bodies)
        data = self.data
        return np.concatenate(
            (
                data.qpos[2:],
                data.qvel,
                data.cinert[agent].ravel(),
                data.cvel[agent].ravel(),
                data.qfrc_actuator[6:],
                data.cfrc_ext[agent].ravel(),
            )
        )

    def agent_contact_cost(self) -> Any:
        """The cost of the forces on the agent's bodies."""
        return contact_cost(self.data.cfrc_ext[: self.agent_bodies])


class Humanoid(_Agent, HumanoidEnv):
    """Gymnasium's Humanoid-v5 with the task's model.

    The forward reward starts from the center of mass that the previous step left, which is one substep old.
    """

    ONE_STEP_BEHIND: ClassVar[tuple[str, ...]] = ("xipos",)

    @property
    def contact_cost(self) -> Any:
        """The contact cost of the agent's bodies only."""
        return self.agent_contact_cost()


class HumanoidStandup(_Agent, HumanoidStandupEnv):
    """Gymnasium's HumanoidStandup-v5 with the task's model.

    ``info["is_success"]``: the height of the torso is in (1, 2) m.
    """

    def _get_rew(self, pos_after: float, action: Any) -> tuple[Any, dict[str, Any]]:
        upward = pos_after / self.model.opt.timestep
        ctrl_cost = self._ctrl_cost_weight * np.square(self.data.ctrl).sum()
        impact_cost = self.agent_contact_cost()
        terms = {"reward_linup": upward, "reward_quadctrl": -ctrl_cost, "reward_impact": -impact_cost}
        return upward - ctrl_cost - impact_cost + 1, terms


class HumanoidStandupAndRun(Humanoid):
    """Humanoid-v5's observation, reset and forward reward on the lying model, and a reward for height.

    Reward: 1.25·Δx/dt + z/timestep − .1·Σctrl² − contact cost + (5 if 1 < z < 2 else 1). Never terminates.

    ``info["is_success"]``: the height of the torso is in (1, 2) m.
    """

    FALLEN_REWARD: ClassVar[float] = 1.0

    def __init__(self, task: Task, **rendering: Any) -> None:
        super().__init__(task, **rendering)
        self._terminate_when_unhealthy = False

    def _get_rew(self, x_velocity: float, action: Any) -> tuple[Any, dict[str, Any]]:
        _, terms = super()._get_rew(x_velocity, action)
        terms["reward_linup"] = self.data.qpos[2] / self.model.opt.timestep
        terms["reward_survive"] = self._healthy_reward if self.is_healthy else self.FALLEN_REWARD
        gains = terms["reward_forward"] + terms["reward_linup"] + terms["reward_survive"]
        return gains + terms["reward_ctrl"] + terms["reward_contact"], terms
