"""The entries of observation and action vectors, as data."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Field:
    """``count`` neighboring entries of a vector with the same meaning, unit and range."""

    meaning: str
    unit: str
    low: float = -math.inf
    high: float = math.inf
    count: int = 1

    @property
    def range(self) -> str:
        """The range as text."""
        if math.isinf(self.low) and math.isinf(self.high):
            return "unbounded"
        return f"{self.low:.6g} … {self.high:.6g}"
