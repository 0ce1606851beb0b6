"""A goal that moves during the episode."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.task import Task
from gym_extensions.catalog.variations.goals import TrackingGoal
from gym_extensions.envs.effects import goals
from gym_extensions.envs.effects.base import Part
from gym_extensions.envs.state import State

if TYPE_CHECKING:
    from gym_extensions.envs.mujoco.task_env import TaskEnv


class Tracking(Part):
    """Moves the goal before the physics of every step; the simulation itself never moves it."""

    def __init__(self, task: Task, tracking: TrackingGoal) -> None:
        self._box = goals.BOXES[task.base]
        self._speed = tracking.speed
        self._velocity = np.zeros(2)

    def reset(self, env: TaskEnv) -> None:
        """Draws the velocity."""
        self._velocity = goals.drawn_velocity(env.np_random, self._speed)

    def before(self, env: TaskEnv) -> None:
        """Puts the goal where it is at the end of the coming step."""
        place = env.goal_place()
        place[:], self._velocity = goals.moved(place, self._velocity, self._box, env.dt)

    def carried(self) -> State:
        """``goal_velocity`` (2,), m/s, in the order of the goal's coordinates: Pusher y, x; Striker x, y."""
        return {"goal_velocity": self._velocity.copy()}

    def carry(self, saved: Mapping[str, NDArray[np.float64]]) -> None:
        """Takes the saved velocity."""
        self._velocity = np.array(saved["goal_velocity"])
