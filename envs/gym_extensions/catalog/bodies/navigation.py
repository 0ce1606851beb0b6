"""The point of 2-D navigation."""

from __future__ import annotations

from gym_extensions.catalog.bodies.body import Body, Prose, RewardBounds, Segments
from gym_extensions.catalog.bodies.success import Arrival

NAVIGATION = (
    Body(
        name="Navigation",
        family="navigation",
        asset="",
        model_name="",
        prose=Prose(
            "A point that finds its way to a goal on a map of 640 × 480 units.",
            "−1 per step, −5 more for a collision, +10 more for reaching the goal.",
            'Uniform over free space at least 100 units from the goal. `options={"start": (x, y)}` sets it.',
            "At the goal: within 20 units of its center after a step.",
            "The paper, section on 2-D navigation.",
        ),
        rewards=RewardBounds(-6.0, -1.0, end=10.0),  # −1 per step, −5 per collision, +10 at the goal
        segments=Segments(tolerance=0.0),  # sums and products alone, the same on every processor
        has_gravity=False,
        success=Arrival("The episode ends at the goal."),
    ),
)
