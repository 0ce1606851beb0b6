"""A goal that moves during the episode, independently of the physics."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from gym_extensions.catalog.bodies.body import Body, Rectangle
from gym_extensions.catalog.task import Task
from gym_extensions.catalog.variations.goals import TrackingGoal
from gym_extensions.envs.effects.base import Effect, EffectKind, VectorEffect, required
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
from gym_extensions.envs.state import State


def goal_area(body: Body) -> Rectangle:
    """Returns the rectangle of a body's goal. Raises ``ValueError`` for a body without a goal."""
    if body.goal_area is None:
        raise ValueError(f"{body.name} has no goal")
    return body.goal_area


def draw_velocity(generator: np.random.Generator, speed: float) -> Array:
    """Draws a goal's velocity, (2,), each component in [−speed, speed], m/s."""
    return generator.uniform(-speed, speed, 2)


def move(position: Array, velocity: Array, area: Rectangle, seconds: float) -> tuple[Array, Array]:
    """Returns position and velocity (…, 2) of a goal that moves straight and is reflected at the edges."""
    low, high = np.array(area.low), np.array(area.high)
    ahead = position + velocity * seconds
    below, above = ahead < low, ahead > high
    reflected = np.where(below, 2 * low - ahead, np.where(above, 2 * high - ahead, ahead))
    return reflected, np.where(below | above, -velocity, velocity)


class TrackingGoalEffect(Effect):
    """Moves the goal of one environment before the physics of every step."""

    def __init__(self, task: Task) -> None:
        self._area = goal_area(task.body)
        self._speed = required(task, TrackingGoal).speed
        self._velocity = np.zeros(2)

    def on_reset(self, simulation: Simulation) -> None:
        """Draws the velocity."""
        self._velocity = draw_velocity(simulation.np_random, self._speed)

    def pre_step(self, simulation: Simulation) -> None:
        """Moves the goal to its position at the end of the step."""
        position = simulation.goal_position()
        position[:], self._velocity = move(position, self._velocity, self._area, simulation.dt)

    def get_state(self) -> State:
        """``goal_velocity`` (2,), m/s, in the order of the goal's coordinates.

        Pusher's are y, x and Striker's x, y.
        """
        return {"goal_velocity": self._velocity.copy()}

    def set_state(self, state: Mapping[str, Array]) -> None:
        """Restores the velocity."""
        self._velocity = np.array(state["goal_velocity"])


class VectorTrackingGoalEffect(VectorEffect):
    """Moves the goals of many environments before the physics of every step."""

    def __init__(self, physics: Physics, templates: Sequence[Template]) -> None:
        task = templates[0].task
        self._area, self._dt = goal_area(task.body), templates[0].dt
        self._speed = required(task, TrackingGoal).speed
        self._velocity = np.zeros((len(templates), 2))
        mocap = templates[0].model.nmocap > 0  # Striker's goal is a mocap body, Pusher's is on slides
        self._position = physics.field("mocap_pos")[:, 0, :2] if mocap else physics.field("qpos")[:, -2:]

    def draw(self, indices: Indices, generators: Generators, rows: dict[str, Array]) -> None:
        """Draws the velocities."""
        self._velocity[indices] = [draw_velocity(generator, self._speed) for generator in generators]

    def pre_step(self, steps: Steps) -> None:
        """Moves the goals to their positions at the end of the step."""
        self._position[...], self._velocity = move(self._position, self._velocity, self._area, self._dt)

    def get_state(self) -> dict[str, Array]:
        """``goal_velocity`` (2,), m/s."""
        return {"goal_velocity": self._velocity.copy()}

    def set_state(self, indices: Indices, state: States) -> None:
        """Restores the velocities."""
        self._velocity[indices] = state["goal_velocity"]


KIND = EffectKind(TrackingGoal, TrackingGoalEffect, VectorTrackingGoalEffect, draw_order=5)
