"""Noise on the motors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from gym_extensions.catalog.variations.base import RuntimeVariation, set_positive

if TYPE_CHECKING:
    import mujoco

    from gym_extensions.catalog.bodies.body import Body


@dataclass(frozen=True)
class MotorNoise(RuntimeVariation):
    """Adds normal noise to the command of every motor and clips the sum to the motor's range.

    ``scale`` is the standard deviation of the noise as a fraction of the motor's range. Reward terms that
    use the action in Gymnasium use the command; terms that use ``ctrl`` use the noisy command.
    """

    scale: float = 0.1

    def __post_init__(self) -> None:
        set_positive(self, "scale")

    @classmethod
    def fits(cls, body: Body) -> bool:
        """Returns whether the body has motors."""
        return body.family != "navigation"

    def describe(self, body: Body, spec: mujoco.MjSpec) -> str:
        """Returns the documentation's sentence."""
        return (
            f"Noise from N(0, ({self.scale:g} × range)²) is added to every motor's command, and the sum is "
            "clipped to the motor's range. All noise of an episode is drawn at reset."
        )
