"""What every environment refuses: a step before the first reset, any use after close, and shared copies."""

from __future__ import annotations

import copy
from typing import TypeVar

from gymnasium import error

from gym_extensions.errors import BenchError

Self = TypeVar("Self", bound="IndependentCopies")


class ResetNeededError(BenchError, error.ResetNeeded):
    """An environment has no state yet. It is also Gymnasium's error of that name."""


class ClosedError(BenchError, error.ClosedEnvironmentError):
    """A vector environment is used after ``close``. It is also Gymnasium's error for that."""


def require_reset(is_set: bool, where: str) -> None:
    """Raises ``ResetNeededError`` unless the environment has a state."""
    if not is_set:
        message = "The environment has no state before its first reset."
        raise ResetNeededError("reset-needed", message, where, "Call reset() first.")


def require_open(closed: bool, where: str) -> None:
    """Raises ``ClosedError`` if the environment is closed."""
    if closed:
        raise ClosedError("closed", "The environment is closed.", where, "Make a new one.")


class IndependentCopies:
    """A mixin whose shallow copies are deep: no two environments share a generator or an array."""

    def __copy__(self: Self) -> Self:
        """Returns a deep copy."""
        return copy.deepcopy(self)
