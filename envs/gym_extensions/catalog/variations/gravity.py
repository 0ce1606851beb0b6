"""Weaker or stronger gravity."""

from __future__ import annotations

from dataclasses import dataclass
from decimal import Decimal
from typing import TYPE_CHECKING

from gym_extensions.catalog.variations.base import BaseVariation, set_positive

if TYPE_CHECKING:
    import mujoco

    from gym_extensions.catalog.bodies.body import Body


@dataclass(frozen=True)
class Gravity(BaseVariation):
    """Multiplies gravity, 9.81 m/s² straight down, by a factor (the paper's gravity tasks)."""

    factor: float

    def __post_init__(self) -> None:
        set_positive(self, "factor")

    @classmethod
    def fits(cls, body: Body) -> bool:
        """Returns whether the body's model has gravity."""
        return body.has_gravity

    def apply(self, spec: mujoco.MjSpec) -> None:
        """Multiplies the model's z-gravity in decimal arithmetic.

        9.81 × 1.25 is the float nearest 12.2625.
        """
        x, y, z = spec.option.gravity
        spec.option.gravity = [x, y, float(Decimal(repr(float(z))) * Decimal(repr(float(self.factor))))]

    def describe(self, body: Body, spec: mujoco.MjSpec) -> str:
        """Returns the documentation's sentence."""
        before = spec.option.gravity[2]
        self.apply(spec)
        return f"Gravity {spec.option.gravity[2]:g} m/s² ({self.factor:g} × {before:g})."
