"""Motors that add noise, and goals that move, in all lanes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.variations.actuation import MotorNoise
from gym_extensions.catalog.variations.goals import TrackingGoal
from gym_extensions.envs.effects import goals, motors
from gym_extensions.envs.effects.base import NOISE_SEEDS
from gym_extensions.envs.effects.vector_base import LanePart, Steps
from gym_extensions.envs.state import DERIVED
from gym_extensions.envs.vector.physics import Array, Lanes, Physics
from gym_extensions.envs.vector.template import Prototype


class NoisyMotors(LanePart):
    """Adds the episode's noise to every command."""

    def __init__(self, lanes: Sequence[Prototype], noise: MotorNoise) -> None:
        self._limit = lanes[0].task.max_steps
        self._scale = noise.scale
        self._ranges = lanes[0].model.actuator_ctrlrange
        self._noise = np.zeros((len(lanes), self._limit, len(self._ranges)))
        self._seeds = np.zeros(len(lanes))

    def draw(self, lanes: Lanes, generators: Sequence[np.random.Generator], rows: dict[str, Array]) -> None:
        """The number from which an episode's noise follows."""
        self._sow(lanes, [float(own.integers(NOISE_SEEDS)) for own in generators])

    def _sow(self, lanes: Lanes, seeds: Sequence[float]) -> None:
        for lane, seed in zip(lanes, seeds, strict=True):
            self._seeds[lane] = seed
            self._noise[lane] = motors.motor_noise(int(seed), self._limit, len(self._ranges))

    def applied(self, ctrl: NDArray[Any], steps: Steps) -> NDArray[Any]:
        """Commands plus the step's noise, clipped to the motors' ranges."""
        noise = self._noise[np.arange(len(ctrl)), steps % self._limit]
        return motors.applied(ctrl, noise, self._ranges, self._scale)

    def carried(self) -> dict[str, Array]:
        """The numbers from which the episodes' noise follows."""
        return {DERIVED + "motor_seed": self._seeds.copy()}

    def carry(self, lanes: Lanes, state: Mapping[str, Array]) -> None:
        """Takes the saved episodes' noise."""
        if DERIVED + "motor_seed" in state:
            self._sow(lanes, list(state[DERIVED + "motor_seed"]))


class TrackingGoals(LanePart):
    """Moves the goals before the physics of every step."""

    def __init__(self, physics: Physics, lanes: Sequence[Prototype], tracking: TrackingGoal) -> None:
        base = lanes[0].task.base
        self._box, self._dt, self._speed = goals.BOXES[base], lanes[0].dt, tracking.speed
        self._velocity = np.zeros((len(lanes), 2))
        self._place = (
            physics.field("mocap_pos")[:, 0, :2] if base == "Striker" else physics.field("qpos")[:, -2:]
        )

    def draw(self, lanes: Lanes, generators: Sequence[np.random.Generator], rows: dict[str, Array]) -> None:
        """Velocities."""
        self._velocity[lanes] = [goals.drawn_velocity(own, self._speed) for own in generators]

    def before(self, steps: Steps) -> None:
        """Puts the goals where they are at the end of the coming step."""
        self._place[...], self._velocity = goals.moved(self._place, self._velocity, self._box, self._dt)

    def carried(self) -> dict[str, Array]:
        """``goal_velocity`` (2,), m/s."""
        return {"goal_velocity": self._velocity.copy()}

    def carry(self, lanes: Lanes, state: Mapping[str, Array]) -> None:
        """Takes the saved velocities."""
        self._velocity[lanes] = state["goal_velocity"]
