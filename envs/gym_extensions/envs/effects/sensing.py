"""The wall and the range sensor while the simulation runs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.task import Task
from gym_extensions.catalog.variations.obstacles import SensorNoise, Wall
from gym_extensions.envs.effects import range_sensor as sensor
from gym_extensions.envs.effects.base import NOISE_SEEDS, Part
from gym_extensions.envs.state import DERIVED, State

if TYPE_CHECKING:
    from gym_extensions.envs.mujoco.task_env import TaskEnv


class StandingWall(Part):
    """Draws the wall's x at reset."""

    def __init__(self, wall: Wall) -> None:
        self._wall = wall

    def reset(self, env: TaskEnv) -> None:
        """Puts the wall's centre at an x from U(nearest, farthest)."""
        x = env.np_random.uniform(self._wall.nearest, self._wall.farthest)
        env.data.mocap_pos[0] = (x, 0.0, self._wall.centre_height)


class Sensor(Part):
    """Appends the range beams; with noise, those of the step before, disturbed."""

    def __init__(self, task: Task, wall: Wall | None, noise: SensorNoise | None) -> None:
        self._fan = sensor.FANS[task.base]
        self._wall = wall
        self._noise = noise
        self._steps = task.max_steps
        self._seed = 0
        self._shown = np.zeros(sensor.BEAMS)

    def _reading(self, env: TaskEnv) -> NDArray[np.float64]:
        if self._wall is None:
            return np.zeros(sensor.BEAMS)
        origins, directions = self._fan(env.data.qpos, env.root_lift)
        half_sizes = np.array(self._wall.half_sizes)
        return sensor.readings(origins, directions, env.data.mocap_pos[0], half_sizes)

    def reset(self, env: TaskEnv) -> None:
        """Draws the episode's noise and shows the present reading."""
        if self._noise is not None:
            self._seed = int(env.np_random.integers(NOISE_SEEDS))
            self._show(env, self._noise, 0)

    def _show(self, env: TaskEnv, noise: SensorNoise, step: int) -> None:
        kept, shift = sensor.beam_noise(self._seed, self._steps, noise.dropout, noise.noise)
        row = step % len(kept)
        self._shown = sensor.disturbed(self._reading(env), kept[row], shift[row])

    def before(self, env: TaskEnv) -> None:
        """Latches what the coming step will show: the reading before it."""
        if self._noise is not None:
            self._show(env, self._noise, env.elapsed + 1)

    def observed(self, env: TaskEnv) -> NDArray[np.float64]:
        """The 10 beams, in [0, 1]."""
        return self._reading(env) if self._noise is None else self._shown.copy()

    def carried(self) -> State:
        """The number from which the episode's noise follows."""
        return {} if self._noise is None else {DERIVED + "sensor_seed": np.array(float(self._seed))}

    def carry(self, saved: Mapping[str, NDArray[np.float64]]) -> None:
        """Takes the saved episode's noise."""
        if DERIVED + "sensor_seed" in saved:
            self._seed = int(saved[DERIVED + "sensor_seed"])
