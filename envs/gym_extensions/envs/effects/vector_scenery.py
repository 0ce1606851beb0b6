"""Walls and range sensors of all lanes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from gym_extensions.catalog.variations.obstacles import SensorNoise, Wall
from gym_extensions.envs.effects import range_sensor as sensor
from gym_extensions.envs.effects.base import NOISE_SEEDS
from gym_extensions.envs.effects.vector_base import LanePart, Steps
from gym_extensions.envs.state import DERIVED
from gym_extensions.envs.vector.physics import Array, Lanes, Physics
from gym_extensions.envs.vector.template import Prototype


class StandingWalls(LanePart):
    """Draws the wall's x at reset in the lanes whose wall is not parked."""

    def __init__(self, walls: Sequence[Wall]) -> None:
        self._walls = walls

    def draw(self, lanes: Lanes, generators: Sequence[np.random.Generator], rows: dict[str, Array]) -> None:
        """Centres at an x from U(nearest, farthest), parked ones where the model has them."""
        places = np.zeros((len(lanes), 1, 3))
        for row, (lane, own) in enumerate(zip(lanes, generators, strict=True)):
            wall = self._walls[lane]
            places[row, 0] = wall.rest
            if not wall.parked:
                places[row, 0, 0] = own.uniform(wall.nearest, wall.farthest)
        rows["mocap_pos"] = places


class Beams(LanePart):
    """Appends the 10 range beams, in [0, 1]."""

    def __init__(self, physics: Physics, lanes: Sequence[Prototype], walls: Sequence[Wall]) -> None:
        self._lanes = len(lanes)
        self._fan = sensor.FANS[lanes[0].task.base]
        self._lift = lanes[0].root_lift
        self._qpos = physics.field("qpos")
        self._centre = physics.field("mocap_pos")[:, 0] if walls else None
        self._half_sizes = np.array(walls[0].half_sizes) if walls else np.zeros(3)

    def _readings(self) -> Array:
        if self._centre is None:
            return np.zeros((self._lanes, sensor.BEAMS))
        origins, directions = self._fan(self._qpos, self._lift)
        return sensor.readings(origins, directions, self._centre, self._half_sizes)

    def observed(self) -> Array:
        """The present readings."""
        return self._readings()


class NoisyBeams(Beams):
    """Appends the beams of the step before, disturbed."""

    def __init__(
        self, physics: Physics, lanes: Sequence[Prototype], walls: Sequence[Wall], noise: SensorNoise
    ) -> None:
        super().__init__(physics, lanes, walls)
        self._noise = noise
        self._limit = lanes[0].task.max_steps
        shape = (len(lanes), self._limit + 1, sensor.BEAMS)
        self._kept, self._shift = np.zeros(shape, np.bool_), np.zeros(shape)
        self._seeds = np.zeros(len(lanes))
        self._shown = np.zeros((len(lanes), sensor.BEAMS))

    def draw(self, lanes: Lanes, generators: Sequence[np.random.Generator], rows: dict[str, Array]) -> None:
        """The number from which an episode's noise follows."""
        self._sow(lanes, [float(own.integers(NOISE_SEEDS)) for own in generators])

    def _sow(self, lanes: Lanes, seeds: Sequence[float]) -> None:
        for lane, seed in zip(lanes, seeds, strict=True):
            self._seeds[lane] = seed
            noise = self._noise
            kept, shift = sensor.beam_noise(int(seed), self._limit, noise.dropout, noise.noise)
            self._kept[lane], self._shift[lane] = kept, shift

    def started(self, lanes: Lanes) -> None:
        """An episode starts with its present reading."""
        clean = self._readings()[lanes]
        self._shown[lanes] = sensor.disturbed(clean, self._kept[lanes, 0], self._shift[lanes, 0])

    def before(self, steps: Steps) -> None:
        """Latches what the coming step will show: the reading before it."""
        row = np.arange(self._lanes), (steps + 1) % (self._limit + 1)
        self._shown = sensor.disturbed(self._readings(), self._kept[row], self._shift[row])

    def observed(self) -> Array:
        """The latched readings."""
        return self._shown

    def carried(self) -> dict[str, Array]:
        """The numbers from which the episodes' noise follows."""
        return {DERIVED + "sensor_seed": self._seeds.copy()}

    def carry(self, lanes: Lanes, state: Mapping[str, Array]) -> None:
        """Takes the saved episodes' noise."""
        if DERIVED + "sensor_seed" in state:
            self._sow(lanes, list(state[DERIVED + "sensor_seed"]))
