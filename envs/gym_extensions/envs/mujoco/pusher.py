"""Gymnasium's Pusher class, with an optional random or moving goal."""

from __future__ import annotations

import numpy as np
from gymnasium.envs.mujoco.pusher_v5 import PusherEnv
from numpy.typing import NDArray

from gym_extensions.catalog.variations.goals import MovingGoal
from gym_extensions.envs.effects.base import variation_of
from gym_extensions.envs.mujoco.arm_starts import APART, PUSHER_GOAL, PUSHER_OBJECT, draw_point
from gym_extensions.envs.mujoco.task_env import TaskEnv

ARM_SPEED = 0.005
"""Largest speed of an arm joint at reset, rad/s (Gymnasium's pusher_v5)."""


class Pusher(TaskEnv, PusherEnv):
    """Gymnasium's Pusher-v5 with the task's model.

    With ``MovingGoal`` the goal's slide offsets (y, x) are drawn first, then the object's, until their
    distance exceeds 0.17 m.

    ``info["is_success"]``: the centers of object and goal are at most 0.05 m apart on the table.
    """

    def start_body(self) -> None:
        """Draws goal, object and arm velocities."""
        if variation_of(self.task, MovingGoal) is None:
            super().start_body()
            return
        self.goal_pos = draw_point(PUSHER_GOAL, self.np_random)
        while True:
            self.cylinder_pos = draw_point(PUSHER_OBJECT, self.np_random)
            if np.linalg.norm(self.cylinder_pos - self.goal_pos) > APART:
                break
        qpos = np.concatenate([self.init_qpos[:-4], self.cylinder_pos, self.goal_pos])
        qvel = self.init_qvel + self.np_random.uniform(-ARM_SPEED, ARM_SPEED, self.model.nv)
        qvel[-4:] = 0
        self.set_state(qpos, qvel)

    def goal_position(self) -> NDArray[np.float64]:
        """The goal's slide offsets (y, x), m, as a view into qpos."""
        offsets: NDArray[np.float64] = self.data.qpos[-2:]
        return offsets
