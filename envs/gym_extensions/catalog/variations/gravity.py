"""Gravity times a factor."""

from __future__ import annotations

from dataclasses import dataclass
from decimal import Decimal
from typing import TYPE_CHECKING

from gym_extensions.catalog.variations.base import positive

if TYPE_CHECKING:
    import mujoco


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
