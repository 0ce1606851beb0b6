"""Sensor noise delays the range sensor by one step, drops beams and adds normal noise."""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence

import numpy as np

from gym_extensions.catalog.task import Task
from gym_extensions.catalog.variations.obstacles import RangeSensor, SensorNoise
from gym_extensions.envs.effects.base import EffectKind, required
from gym_extensions.envs.effects.range_sensor import BEAMS, RangeSensorEffect, VectorRangeSensorEffect
from gym_extensions.envs.effects.seeded_noise import CACHED_EPISODES, SeededNoise, VectorSeededNoise
from gym_extensions.envs.protocols import Array, Flags, Indices, Physics, Simulation, States, Steps, Template
from gym_extensions.envs.state import DERIVED, State

SEED = DERIVED + "sensor_seed"
LATCHED = DERIVED + "sensor_readings"


@functools.lru_cache(maxsize=CACHED_EPISODES)
def beam_noise(seed: int, steps: int, dropout: float, noise: float) -> tuple[Flags, Array]:
    """The noise of an episode, with one row per step from 0 for the working beams and the noise on hits.

    Both arrays are (steps + 1, 10), follow from the seed, and are read-only.
    """
    generator = np.random.Generator(np.random.PCG64(seed))
    shape = (steps + 1, BEAMS)
    working, shift = generator.random(shape) >= dropout, noise * generator.standard_normal(shape)
    working.flags.writeable = shift.flags.writeable = False
    return working, shift


def disturb(readings: Array, working: Flags, shift: Array) -> Array:
    """Adds noise to beams that hit, clipped to [0, 1]. Beams that miss or drop out read 0."""
    return np.where((readings > 0) & working, np.clip(readings + shift, 0.0, 1.0), 0.0)


class SensorNoiseEffect(SeededNoise, RangeSensorEffect):
    """Appends the noisy readings of the step before in one environment."""

    seed_key = SEED

    def __init__(self, task: Task) -> None:
        super().__init__(task)
        self._noise = required(task, SensorNoise)
        self._max_steps = task.max_steps
        self._latched = np.zeros(BEAMS)

    def _latch(self, simulation: Simulation, step: int) -> None:
        working, shift = beam_noise(self.seed, self._max_steps, self._noise.dropout, self._noise.noise)
        row = step % len(working)
        self._latched = disturb(self.reading(simulation), working[row], shift[row])

    def on_reset(self, simulation: Simulation) -> None:
        """Draws the episode's noise. The first observation has the present reading."""
        super().on_reset(simulation)
        self._latch(simulation, 0)

    def pre_step(self, simulation: Simulation) -> None:
        """Latches the reading before the step, which the next observation shows."""
        self._latch(simulation, simulation.elapsed + 1)

    def observation(self, simulation: Simulation) -> Array:
        """The latched readings."""
        return self._latched.copy()

    def get_state(self) -> State:
        """The seed of the episode's noise, and the readings that the observation shows."""
        return super().get_state() | {LATCHED: self._latched.copy()}

    def set_state(self, state: Mapping[str, Array]) -> None:
        """Restores the seed of the episode's noise, and the readings."""
        super().set_state(state)
        if LATCHED in state:
            self._latched = np.array(state[LATCHED])


class VectorSensorNoiseEffect(VectorSeededNoise, VectorRangeSensorEffect):
    """Appends the noisy readings of the step before in many environments."""

    seed_key = SEED

    def __init__(self, physics: Physics, templates: Sequence[Template]) -> None:
        super().__init__(physics, templates)
        self._noise = required(templates[0].task, SensorNoise)
        self._max_steps = templates[0].task.max_steps
        shape = (len(templates), self._max_steps + 1, BEAMS)
        self._working, self._shift = np.zeros(shape, np.bool_), np.zeros(shape)
        self.seeds = np.zeros(len(templates))
        self._latched = np.zeros((len(templates), BEAMS))

    def fill_noise(self, index: int, seed: int) -> None:
        """Computes the noise of an environment's episode."""
        noise = beam_noise(seed, self._max_steps, self._noise.dropout, self._noise.noise)
        self._working[index], self._shift[index] = noise

    def on_reset(self, indices: Indices) -> None:
        """The first observation has the present reading."""
        readings = self.reading()[indices]
        self._latched[indices] = disturb(readings, self._working[indices, 0], self._shift[indices, 0])

    def pre_step(self, steps: Steps) -> None:
        """Latches the readings before the step, which the next observations show."""
        row = np.arange(len(steps)), (steps + 1) % (self._max_steps + 1)
        self._latched = disturb(self.reading(), self._working[row], self._shift[row])

    def observation(self) -> Array:
        """The latched readings."""
        return self._latched

    def get_state(self) -> dict[str, Array]:
        """The seeds of the episodes' noise, and the readings that the observations show."""
        return super().get_state() | {LATCHED: self._latched.copy()}

    def set_state(self, indices: Indices, state: States) -> None:
        """Restores the seeds of the episodes' noise, and the readings."""
        super().set_state(indices, state)
        if LATCHED in state:
            self._latched[indices] = state[LATCHED]


KIND = EffectKind(SensorNoise, SensorNoiseEffect, VectorSensorNoiseEffect, draw_order=3, replaces=RangeSensor)
