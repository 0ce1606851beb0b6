"""Goals and starts that are drawn or move."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from gym_extensions.catalog.variations.base import AtRunTime, positive

if TYPE_CHECKING:
    pass


@dataclass(frozen=True)
class MovingGoal(AtRunTime):
    """Pusher's goal is drawn at every reset, the object then away from it (paper, PusherMovingGoal)."""


@dataclass(frozen=True)
class MovingStart(AtRunTime):
    """Striker's ball is drawn at every reset, the goal then away from it (paper, StrikerMovingStart)."""


@dataclass(frozen=True)
class TrackingGoal(AtRunTime):
    """The goal moves during the episode at a velocity drawn at reset, reflected at the box it is drawn from.

    ``speed`` bounds each component of the velocity, m/s.
    """

    speed: float = 0.2

    def __post_init__(self) -> None:
        positive("TrackingGoal's speed", self.speed)
