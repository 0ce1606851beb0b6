"""Where the goal, object and ball of the arm tasks start."""

from __future__ import annotations

import numpy as np

from gym_extensions.catalog.bodies import body
from gym_extensions.catalog.bodies.body import Rectangle
from gym_extensions.envs.effects.moving_goal import goal_area
from gym_extensions.envs.protocols import Array

APART = 0.17
"""Least distance between object and goal at reset, m (the arm tasks of 2017 and of Gymnasium)."""
PUSHER_GOAL = goal_area(body("Pusher"))
"""Slide offsets (y, x) of PusherMovingGoal's goal."""
PUSHER_OBJECT = Rectangle((-0.3, -0.2), (0.0, 0.2))
"""Slide offsets (y, x) of Pusher's object."""
STRIKER_GOAL = goal_area(body("Striker"))
"""World (x, y) of Striker's goal."""
STRIKER_BALL = Rectangle((0.43, -0.3), (0.55, -0.05))
"""World (x, y) of StrikerMovingStart's ball."""
STRIKER_BALL_FIXED = (0.5, -0.175)
"""World (x, y) of Striker's ball."""


def draw_point(area: Rectangle, generator: np.random.Generator) -> Array:
    """Draws a point, (2,), uniformly from a rectangle, one coordinate after the other."""
    return np.array([generator.uniform(area.low[axis], area.high[axis]) for axis in (0, 1)])
