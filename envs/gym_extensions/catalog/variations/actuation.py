"""Noise on the motors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from gym_extensions.catalog.variations.base import AtRunTime, positive

if TYPE_CHECKING:
    pass


@dataclass(frozen=True)
class MotorNoise(AtRunTime):
    """Every motor gets its command plus normal noise, clipped to its range.

    ``scale`` is the noise's standard deviation as a share of the motor's range. Rewards use the command where
    Gymnasium's use the action, and what was applied where they use ``ctrl``.
    """

    scale: float = 0.1

    def __post_init__(self) -> None:
        positive("MotorNoise's scale", self.scale)
