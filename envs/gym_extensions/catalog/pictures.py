"""Which large picture shows a task. Tasks that look alike share one."""

from __future__ import annotations

from gym_extensions.catalog.registry import task
from gym_extensions.catalog.task import Task
from gym_extensions.catalog.variations.goals import MovingGoal, MovingStart, TrackingGoal
from gym_extensions.catalog.variations.morphology import LimbScale
from gym_extensions.catalog.variations.obstacles import RangeSensor, SensorNoise, Wall

VISIBLE = (LimbScale, MovingGoal, MovingStart, RangeSensor, TrackingGoal, Wall)
"""Variations that change the picture."""


def large_picture(row: Task) -> str:
    """Returns the file name of the picture of a task; empty in 2-D navigation, whose maps are drawn.

    Example:
        >>> from gym_extensions.catalog.registry import task
        >>> large_picture(task("HopperGravityHalf")), large_picture(task("HopperBigFoot"))
        ('hopper.webp', 'hopperbigfoot.webp')
    """
    if row.body.camera is None:
        return ""
    visible = [variation for variation in row.variations if isinstance(variation, VISIBLE)]
    if not visible:
        return f"{row.base.lower()}.webp"
    if any(isinstance(variation, SensorNoise) for variation in row.variations):
        return large_picture(task(row.name.replace("Noisy", "")))
    return f"{row.name.lower()}.webp"
