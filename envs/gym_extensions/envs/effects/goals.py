"""Goals of the arm tasks as pure functions: where they are drawn, and how they move."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

APART = 0.17
"""Least distance of object and goal at reset, m (2017's and Gymnasium's arm tasks)."""


@dataclass(frozen=True)
class Box:
    """A rectangle, m, from which a place is drawn uniformly, one coordinate after the other."""

    low: tuple[float, float]
    high: tuple[float, float]

    def draw(self, generator: np.random.Generator) -> Array:
        """One place, (2,)."""
        return np.array([generator.uniform(self.low[axis], self.high[axis]) for axis in (0, 1)])


def drawn_velocity(generator: np.random.Generator, speed: float) -> Array:
    """A goal's velocity, (2,), each component in [−speed, speed], m/s."""
    return generator.uniform(-speed, speed, 2)


def moved(place: Array, velocity: Array, box: Box, seconds: float) -> tuple[Array, Array]:
    """Place and velocity (…, 2) after some time: straight on, reflected at the box's edges."""
    low, high = np.array(box.low), np.array(box.high)
    ahead = place + velocity * seconds
    below, above = ahead < low, ahead > high
    reflected = np.where(below, 2 * low - ahead, np.where(above, 2 * high - ahead, ahead))
    return reflected, np.where(below | above, -velocity, velocity)


PUSHER_GOAL = Box((-0.2, -0.1), (0.0, 0.3))
"""Slide offsets (y, x) of PusherMovingGoal's goal."""
PUSHER_OBJECT = Box((-0.3, -0.2), (0.0, 0.2))
"""Slide offsets (y, x) of Pusher's object."""
STRIKER_GOAL = Box((0.15, 0.1), (0.7, 1.0))
"""World (x, y) of Striker's goal."""
STRIKER_BALL = Box((0.43, -0.3), (0.55, -0.05))
"""World (x, y) of StrikerMovingStart's ball."""
STRIKER_BALL_FIXED = (0.5, -0.175)
"""World (x, y) of Striker's ball."""
BOXES = {"Pusher": PUSHER_GOAL, "Striker": STRIKER_GOAL}
"""Where a goal that moves during the episode stays."""
