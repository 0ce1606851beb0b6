"""Noise on the motors, and goals that move."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.bodies import Rectangle
from gym_extensions.catalog.variations import MotorNoise, TrackingGoal
from gym_extensions.envs.effects.base import Effect, EffectKind, SeededNoise, variation_of
from gym_extensions.envs.interfaces import Array, Fields, Generators, Indices, Steps, Template


def motor_noise(seed: int, steps: int, motors: int) -> Array:
    """The standard normal noise of an episode, (steps, motors). It follows from the seed."""
    return np.random.Generator(np.random.PCG64(seed)).standard_normal((steps, motors))


class MotorNoiseEffect(SeededNoise):
    """Adds the episodes' noise to every command."""

    kept = ("_noise",)

    def __init__(self, fields: Fields, templates: Sequence[Template]) -> None:
        self._max_steps = templates[0].task.max_steps
        self._scale = variation_of(templates[0].task, MotorNoise).scale
        self._ranges = templates[0].model.actuator_ctrlrange
        self._noise = np.zeros((len(templates), self._max_steps, len(self._ranges)))

    def fill_noise(self, index: int, seed: int) -> None:
        self._noise[index] = motor_noise(seed, self._max_steps, len(self._ranges))

    def control(self, ctrl: NDArray[Any], steps: Steps) -> NDArray[Any]:
        """Commands plus noise of ``scale`` × the motors' range, clipped to that range."""
        noise = self._noise[np.arange(len(ctrl)), steps % self._max_steps]
        low, high = self._ranges[:, 0], self._ranges[:, 1]
        return np.clip(ctrl + self._scale * (high - low) * noise, low, high)


def move(position: Array, velocity: Array, area: Rectangle, seconds: float) -> tuple[Array, Array]:
    """Returns position and velocity (…, 2) of a goal that moves straight and is reflected at the edges."""
    low, high = np.array(area.low), np.array(area.high)
    ahead = position + velocity * seconds
    below, above = ahead < low, ahead > high
    reflected = np.where(below, 2 * low - ahead, np.where(above, 2 * high - ahead, ahead))
    return reflected, np.where(below | above, -velocity, velocity)


class TrackingGoalEffect(Effect):
    """Moves the goals before the physics of every step."""

    kept = ("_velocity",)

    def __init__(self, fields: Fields, templates: Sequence[Template]) -> None:
        task = templates[0].task
        assert task.body.goal_area is not None, "the variation fits only bodies with one"
        self._area, self._dt = task.body.goal_area, templates[0].dt
        self._speed = variation_of(task, TrackingGoal).speed
        self._velocity = np.zeros((len(templates), 2))
        mocap = templates[0].model.nmocap > 0  # Striker's goal is a mocap body, Pusher's is on slides
        self._position = fields.field("mocap_pos")[:, 0, :2] if mocap else fields.field("qpos")[:, -2:]

    def draw(self, indices: Indices, generators: Generators, starts: dict[str, Array]) -> None:
        speed = self._speed
        self._velocity[indices] = [generator.uniform(-speed, speed, 2) for generator in generators]

    def pre_step(self, steps: Steps) -> None:
        """Moves the goals to their positions at the end of the step."""
        self._position[...], self._velocity = move(self._position, self._velocity, self._area, self._dt)


KINDS = (
    EffectKind(MotorNoise, MotorNoiseEffect),
    EffectKind(TrackingGoal, TrackingGoalEffect),
)
"""The effects of this module. A new one is the last, because effects draw in this order."""
