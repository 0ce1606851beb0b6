"""Each kind of difference between a task and its base: a frozen value that edits an MjSpec handed to it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from decimal import Decimal
from numbers import Real
from typing import TYPE_CHECKING, Protocol

from gym_extensions.catalog.errors import BenchError

if TYPE_CHECKING:
    import mujoco


class Variation(Protocol):
    """A difference as a value; applying several of different parts gives the same model in any order."""

    def apply(self, spec: mujoco.MjSpec) -> None:
        """Edits the model's specification in place, before it is compiled."""


def positive(name: str, value: object) -> None:
    """Raises ``BenchError`` unless the value is a finite number above zero."""
    if not (isinstance(value, Real) and math.isfinite(value) and value > 0):
        raise BenchError("bad-factor", f"{name} is {value!r}.", hint="Give a finite number above 0.")


@dataclass(frozen=True)
class Gravity:
    """Gravity times a factor: 9.81 m/s² × factor, straight down; nothing else changes (paper, the gravity groups)."""

    factor: float

    def __post_init__(self) -> None:
        positive("Gravity's factor", self.factor)

    def apply(self, spec: mujoco.MjSpec) -> None:
        """Multiplies the model's z-gravity; in decimals, so that 9.81 × 1.25 is the float nearest 12.2625."""
        x, y, z = spec.option.gravity
        spec.option.gravity = [x, y, float(Decimal(repr(float(z))) * Decimal(repr(float(self.factor))))]
