"""Motor noise while the simulation runs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.task import Task
from gym_extensions.catalog.variations.actuation import MotorNoise
from gym_extensions.envs.effects import motors
from gym_extensions.envs.effects.base import NOISE_SEEDS, Part
from gym_extensions.envs.state import DERIVED, State

if TYPE_CHECKING:
    from gym_extensions.envs.mujoco.task_env import TaskEnv


class Motors(Part):
    """Adds the episode's noise to every command."""

    def __init__(self, task: Task, noise: MotorNoise) -> None:
        self._steps = task.max_steps
        self._scale = noise.scale
        self._seed = 0

    def reset(self, env: TaskEnv) -> None:
        """Draws the number from which the episode's noise follows."""
        self._seed = int(env.np_random.integers(NOISE_SEEDS))

    def applied(self, env: TaskEnv, ctrl: NDArray[Any]) -> NDArray[Any]:
        """The command plus the step's noise, clipped to the motors' ranges."""
        ranges = env.model.actuator_ctrlrange
        noise = motors.motor_noise(self._seed, self._steps, len(ranges))
        return motors.applied(ctrl, noise[env.elapsed % self._steps], ranges, self._scale)

    def carried(self) -> State:
        """The number from which the episode's noise follows."""
        return {DERIVED + "motor_seed": np.array(float(self._seed))}

    def carry(self, saved: Mapping[str, NDArray[np.float64]]) -> None:
        """Takes the saved episode's noise."""
        if DERIVED + "motor_seed" in saved:
            self._seed = int(saved[DERIVED + "motor_seed"])
