"""Striker is an arm that strikes a ball into a cup."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from gymnasium.envs.mujoco.pusher_v5 import PusherEnv
from numpy.typing import NDArray

from gym_extensions.catalog.task import Task
from gym_extensions.catalog.variations.goals import MovingStart
from gym_extensions.envs.effects.base import variation_of
from gym_extensions.envs.mujoco.arm_starts import (
    APART,
    STRIKER_BALL,
    STRIKER_BALL_FIXED,
    STRIKER_GOAL,
    draw_point,
)
from gym_extensions.envs.mujoco.task_env import TaskEnv
from gym_extensions.envs.protocols import Array
from gym_extensions.envs.state import State

ARM_SPEED = 0.1
"""Largest speed of an arm joint at reset, rad/s."""
STRIKE = 0.1
"""The tip strikes the ball when their distance is below this, m."""
DISTANCE_WEIGHT, CTRL_WEIGHT, NEAR_WEIGHT = 3.0, 0.1, 0.5


def facing(ball: Array, goal: Array) -> Array:
    """The quaternion of a goal at (x, y) whose open side, −y at rest, faces a ball at (x, y)."""
    turn = math.atan2(ball[0] - goal[0], goal[1] - ball[1])
    return np.array([math.cos(turn / 2), 0.0, 0.0, math.sin(turn / 2)])


class Striker(TaskEnv, PusherEnv):
    """Gym's Striker-v0 on a model rebuilt from Gymnasium's pusher. Rewards use the state after a step.

    Task state: ``best_distance``, the smallest distance of ball and goal so far in the episode, including
    reset; ``struck``, 1 once the tip has come within 0.1 m of the ball; ``strike_place`` (3,), the tip's
    position when it was last within 0.1 m.

    ``info["is_success"]``: the centers of ball and goal are at most 0.05 m apart on the table.
    """

    def __init__(self, task: Task, **rendering: Any) -> None:
        self._best_distance = math.inf
        self._struck = False
        self._strike_place = np.zeros(3)
        super().__init__(task, **rendering)

    def start_body(self) -> None:
        """Draws ball, goal and arm velocities, and clears the record of the episode."""
        moving = variation_of(self.task, MovingStart) is not None
        ball = draw_point(STRIKER_BALL, self.np_random) if moving else np.array(STRIKER_BALL_FIXED)
        while True:
            goal = draw_point(STRIKER_GOAL, self.np_random)
            if np.linalg.norm(ball - goal) >= APART:
                break
        qvel = self.init_qvel.copy()
        qvel[:7] = self.np_random.uniform(-ARM_SPEED, ARM_SPEED, 7)
        qpos = np.concatenate([self.init_qpos[:7], ball[::-1]])
        self.data.mocap_pos[0, :2] = goal
        self.data.mocap_quat[0] = facing(ball, goal)
        self.set_state(qpos, qvel)
        self._struck, self._strike_place = False, np.zeros(3)
        self._best_distance = self._ball_to_goal()

    def _ball_to_goal(self) -> float:
        return float(np.linalg.norm(self.data.body("object").xpos - self.data.body("goal").xpos))

    def _get_rew(self, action: NDArray[Any]) -> tuple[Any, dict[str, Any]]:
        ball, tip = self.data.body("object").xpos, self.data.body("tips_arm").xpos
        self._best_distance = min(self._best_distance, self._ball_to_goal())
        if np.linalg.norm(tip - ball) < STRIKE:
            self._struck, self._strike_place = True, tip.copy()
        near = np.linalg.norm(ball - (self._strike_place if self._struck else tip))
        terms = {
            # A Python float would take on the precision of a float32 action's cost in the sum.
            "reward_dist": -DISTANCE_WEIGHT * np.float64(self._best_distance),
            "reward_ctrl": -CTRL_WEIGHT * np.square(action).sum(),
            "reward_near": -NEAR_WEIGHT * near,
        }
        return terms["reward_dist"] + terms["reward_ctrl"] + terms["reward_near"], terms

    def goal_position(self) -> Array:
        """The goal's world (x, y), m, as a view into its mocap position."""
        position: Array = self.data.mocap_pos[0, :2]
        return position

    def get_task_state(self) -> State:
        """Returns ``best_distance``, ``struck`` and ``strike_place``."""
        return {
            "best_distance": np.array(self._best_distance if math.isfinite(self._best_distance) else 0.0),
            "struck": np.array(float(self._struck)),
            "strike_place": self._strike_place.copy(),
        }

    def set_task_state(self, saved: Mapping[str, Array]) -> None:
        """Restores the record of a saved episode."""
        self._best_distance = float(saved["best_distance"])
        self._struck = bool(saved["struck"])
        self._strike_place = np.array(saved["strike_place"])
