"""Motor noise adds normal noise to every command."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.task import Task
from gym_extensions.catalog.variations.actuation import MotorNoise
from gym_extensions.envs.effects.base import EffectKind, required
from gym_extensions.envs.effects.seeded_noise import CACHED_EPISODES, SeededNoise, VectorSeededNoise
from gym_extensions.envs.protocols import Array, Physics, Simulation, Steps, Template
from gym_extensions.envs.state import DERIVED

SEED = DERIVED + "motor_seed"


@functools.lru_cache(maxsize=CACHED_EPISODES)
def motor_noise(seed: int, steps: int, motors: int) -> Array:
    """The standard normal noise of an episode, (steps, motors), read-only. It follows from the seed."""
    noise = np.random.Generator(np.random.PCG64(seed)).standard_normal((steps, motors))
    noise.flags.writeable = False
    return noise


def noisy_control(commands: NDArray[Any], noise: Array, ranges: Array, scale: float) -> Array:
    """Commands (…, motors) plus noise of ``scale`` × the motors' range, clipped to that range.

    ``ranges`` is (motors, 2), low and high; ``noise`` is standard normal, shaped as the commands.
    """
    low, high = ranges[:, 0], ranges[:, 1]
    return np.clip(commands + scale * (high - low) * noise, low, high)


class MotorNoiseEffect(SeededNoise):
    """Adds the episode's noise to every command of one environment."""

    seed_key = SEED

    def __init__(self, task: Task) -> None:
        self._max_steps = task.max_steps
        self._scale = required(task, MotorNoise).scale

    def control(self, simulation: Simulation, ctrl: NDArray[Any]) -> NDArray[Any]:
        """The command plus the noise of the step."""
        ranges = simulation.model.actuator_ctrlrange
        noise = motor_noise(self.seed, self._max_steps, len(ranges))
        return noisy_control(ctrl, noise[simulation.elapsed % self._max_steps], ranges, self._scale)


class VectorMotorNoiseEffect(VectorSeededNoise):
    """Adds the episodes' noise to every command of many environments."""

    seed_key = SEED

    def __init__(self, physics: Physics, templates: Sequence[Template]) -> None:
        self._max_steps = templates[0].task.max_steps
        self._scale = required(templates[0].task, MotorNoise).scale
        self._ranges = templates[0].model.actuator_ctrlrange
        self._noise = np.zeros((len(templates), self._max_steps, len(self._ranges)))
        self.seeds = np.zeros(len(templates))

    def fill_noise(self, index: int, seed: int) -> None:
        """Computes the noise of an environment's episode."""
        self._noise[index] = motor_noise(seed, self._max_steps, len(self._ranges))

    def control(self, ctrl: NDArray[Any], steps: Steps) -> NDArray[Any]:
        """The commands plus the noise of the step."""
        noise = self._noise[np.arange(len(ctrl)), steps % self._max_steps]
        return noisy_control(ctrl, noise, self._ranges, self._scale)


KIND = EffectKind(MotorNoise, MotorNoiseEffect, VectorMotorNoiseEffect, draw_order=4)
