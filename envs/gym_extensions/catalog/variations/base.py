"""What every kind of variation has in common."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Protocol, SupportsFloat

from gym_extensions.errors import BenchError

if TYPE_CHECKING:
    import mujoco

    from gym_extensions.catalog.bodies.body import Body


class Variation(Protocol):
    """A difference between a task and its base body, as a frozen value.

    Variations of different parts give the same model in any order.
    """

    def apply(self, spec: mujoco.MjSpec) -> None:
        """Edits the model's specification in place, before it is compiled."""


class BaseVariation:
    """A variation that changes nothing, fits every body, and describes itself by its values."""

    def apply(self, spec: mujoco.MjSpec) -> None:
        """Leaves the model as it is."""

    @classmethod
    def fits(cls, body: Body) -> bool:
        """Returns whether the variation can be applied to the base body."""
        return True

    def describe(self, body: Body, spec: mujoco.MjSpec) -> str:
        """Returns the documentation's sentence about the variation.

        Args:
            body: the base body.
            spec: the body's specification without variations; the method may edit it.
        """
        return f"{self!r}."


class RuntimeVariation(BaseVariation):
    """A variation that acts while the simulation runs and leaves the model of the base body unchanged."""


def set_positive(variation: BaseVariation, *names: str) -> None:
    """Stores fields of a frozen variation as floats, so that equal numbers of any type give one task.

    Raises:
        BenchError: a value is not a finite number above 0.
    """
    for name in names:
        value = getattr(variation, name)
        number = finite(value)
        if number is None or number <= 0:
            message = f"{type(variation).__name__}'s {name} is {value!r}."
            raise BenchError("bad-factor", message, hint="Give a finite number above 0.")
        object.__setattr__(variation, name, number)


def finite(value: object) -> float | None:
    """The value as a float; None if it is not a finite number."""
    number = float(value) if isinstance(value, SupportsFloat) and not isinstance(value, bool) else math.nan
    return number if math.isfinite(number) else None
