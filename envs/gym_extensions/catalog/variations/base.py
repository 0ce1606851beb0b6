"""Each kind of difference between a task and its base: a frozen value that edits an MjSpec handed to it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Protocol, SupportsFloat

from gym_extensions.errors import BenchError

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


class AtRunTime:
    """A difference in what happens while the simulation runs: the model is the base's."""

    def apply(self, spec: mujoco.MjSpec) -> None:
        """Leaves the model as it is."""
