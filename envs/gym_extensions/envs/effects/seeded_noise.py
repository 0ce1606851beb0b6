"""Effects whose noise in an episode follows from one number, the seed that is drawn at reset."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np

from gym_extensions.envs.effects.base import Effect, VectorEffect
from gym_extensions.envs.protocols import Array, Generators, Indices, Simulation, States
from gym_extensions.envs.state import State

NOISE_SEEDS = 2**32
"""Seeds are below this. Replay restores the seed and needs no generator."""
CACHED_EPISODES = 256
"""Number of episodes whose noise is cached, enough for this number of environments."""


class SeededNoise(Effect):
    """Draws, saves and restores the seed of the episode's noise in one environment."""

    seed_key: ClassVar[str]
    seed = 0

    def on_reset(self, simulation: Simulation) -> None:
        """Draws the seed of the episode's noise."""
        self.seed = int(simulation.np_random.integers(NOISE_SEEDS))

    def get_state(self) -> State:
        """The seed of the episode's noise."""
        return {self.seed_key: np.array(float(self.seed))}

    def set_state(self, state: Mapping[str, Array]) -> None:
        """Restores the seed of the episode's noise."""
        if self.seed_key in state:
            self.seed = int(state[self.seed_key])


class VectorSeededNoise(VectorEffect):
    """Draws, saves and restores the seeds of the episodes' noise in many environments."""

    seed_key: ClassVar[str]
    seeds: Array

    def fill_noise(self, index: int, seed: int) -> None:
        """Computes the noise of an environment's episode."""
        raise NotImplementedError

    def draw(self, indices: Indices, generators: Generators, rows: dict[str, Array]) -> None:
        """Draws the seeds of the episodes' noise."""
        self._set_seeds(indices, [float(generator.integers(NOISE_SEEDS)) for generator in generators])

    def _set_seeds(self, indices: Indices, seeds: Sequence[float]) -> None:
        for index, seed in zip(indices, seeds, strict=True):
            self.seeds[index] = seed
            self.fill_noise(index, int(seed))

    def get_state(self) -> dict[str, Array]:
        """The seeds of the episodes' noise."""
        return {self.seed_key: self.seeds.copy()}

    def set_state(self, indices: Indices, state: States) -> None:
        """Restores the seeds of the episodes' noise."""
        if self.seed_key in state:
            self._set_seeds(indices, list(state[self.seed_key]))
