"""Motor noise adds normal noise to every command."""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.task import Task
from gym_extensions.catalog.variations.actuation import MotorNoise
from gym_extensions.envs.effects.base import (
    CACHED_EPISODES,
    NOISE_SEEDS,
    Effect,
    EffectKind,
    VectorEffect,
    required,
)
from gym_extensions.envs.protocols import (
    Array,
    Generators,
    Indices,
    Physics,
    Simulation,
    States,
    Steps,
    Template,
)
from gym_extensions.envs.state import DERIVED, State

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


class MotorNoiseEffect(Effect):
    """Adds the episode's noise to every command of one environment."""

    def __init__(self, task: Task) -> None:
        self._max_steps = task.max_steps
        self._scale = required(task, MotorNoise).scale
        self._seed = 0

    def on_reset(self, simulation: Simulation) -> None:
        """Draws the seed of the episode's noise."""
        self._seed = int(simulation.np_random.integers(NOISE_SEEDS))

    def control(self, simulation: Simulation, ctrl: NDArray[Any]) -> NDArray[Any]:
        """The command plus the noise of the step."""
        ranges = simulation.model.actuator_ctrlrange
        noise = motor_noise(self._seed, self._max_steps, len(ranges))
        return noisy_control(ctrl, noise[simulation.elapsed % self._max_steps], ranges, self._scale)

    def get_state(self) -> State:
        """The seed of the episode's noise."""
        return {SEED: np.array(float(self._seed))}

    def set_state(self, state: Mapping[str, Array]) -> None:
        """Restores the seed of the episode's noise."""
        if SEED in state:
            self._seed = int(state[SEED])


class VectorMotorNoiseEffect(VectorEffect):
    """Adds the episodes' noise to every command of many environments."""

    def __init__(self, physics: Physics, templates: Sequence[Template]) -> None:
        self._max_steps = templates[0].task.max_steps
        self._scale = required(templates[0].task, MotorNoise).scale
        self._ranges = templates[0].model.actuator_ctrlrange
        self._noise = np.zeros((len(templates), self._max_steps, len(self._ranges)))
        self._seeds = np.zeros(len(templates))

    def draw(self, indices: Indices, generators: Generators, rows: dict[str, Array]) -> None:
        """Draws the seeds of the episodes' noise."""
        self._seed(indices, [float(generator.integers(NOISE_SEEDS)) for generator in generators])

    def _seed(self, indices: Indices, seeds: Sequence[float]) -> None:
        for index, seed in zip(indices, seeds, strict=True):
            self._seeds[index] = seed
            self._noise[index] = motor_noise(int(seed), self._max_steps, len(self._ranges))

    def control(self, ctrl: NDArray[Any], steps: Steps) -> NDArray[Any]:
        """The commands plus the noise of the step."""
        noise = self._noise[np.arange(len(ctrl)), steps % self._max_steps]
        return noisy_control(ctrl, noise, self._ranges, self._scale)

    def get_state(self) -> dict[str, Array]:
        """The seeds of the episodes' noise."""
        return {SEED: self._seeds.copy()}

    def set_state(self, indices: Indices, state: States) -> None:
        """Restores the seeds of the episodes' noise."""
        if SEED in state:
            self._seed(indices, list(state[SEED]))


KIND = EffectKind(MotorNoise, MotorNoiseEffect, VectorMotorNoiseEffect, draw_order=4)
