"""Each kind of difference between a task and its base: a frozen value that edits an MjSpec handed to it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from decimal import Decimal
from typing import TYPE_CHECKING, Protocol, SupportsFloat

from gym_extensions.catalog.errors import BenchError

if TYPE_CHECKING:
    import mujoco


class Variation(Protocol):
    """A difference as a value; applying several of different parts gives the same model in any order."""

    def apply(self, spec: mujoco.MjSpec) -> None:
        """Edits the model's specification in place, before it is compiled."""


def positive(name: str, value: object) -> None:
    """Raises ``BenchError`` unless the value is a finite number above zero."""
    number = float(value) if isinstance(value, SupportsFloat) and not isinstance(value, bool) else math.nan
    if not (math.isfinite(number) and number > 0):
        raise BenchError("bad-factor", f"{name} is {value!r}.", hint="Give a finite number above 0.")


@dataclass(frozen=True)
class Gravity:
    """Gravity times a factor: 9.81 m/s² × factor, straight down; nothing else changes (paper: gravity)."""

    factor: float

    def __post_init__(self) -> None:
        positive("Gravity's factor", self.factor)

    def apply(self, spec: mujoco.MjSpec) -> None:
        """Multiplies the model's z-gravity; in decimals, so that 9.81 × 1.25 is the float nearest 12.2625."""
        x, y, z = spec.option.gravity
        spec.option.gravity = [x, y, float(Decimal(repr(float(z))) * Decimal(repr(float(self.factor))))]


class AtRunTime:
    """A difference in what happens while the simulation runs: the model is the base's."""

    def apply(self, spec: mujoco.MjSpec) -> None:
        """Leaves the model as it is."""


@dataclass(frozen=True)
class MotorNoise(AtRunTime):
    """Every motor gets its command plus normal noise, clipped to its range.

    ``scale`` is the noise's standard deviation as a share of the motor's range. Rewards use the command where
    Gymnasium's use the action, and what was applied where they use ``ctrl``.
    """

    scale: float = 0.1

    def __post_init__(self) -> None:
        positive("MotorNoise's scale", self.scale)


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
