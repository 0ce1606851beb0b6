"""A straight scale from values to places in a drawing, with round ticks."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True)
class Axis:
    """Maps ``low … high`` to ``start … end``; values outside are drawn at the nearer end."""

    low: float
    high: float
    start: float
    end: float

    def at(self, value: float) -> float:
        """The place of a value, held within the drawing."""
        share = (min(max(value, self.low), self.high) - self.low) / (self.high - self.low)
        return self.start + share * (self.end - self.start)

    def holds(self, value: float) -> bool:
        """Whether the value lies within the scale."""
        return self.low <= value <= self.high

    def ticks(self, most: int = 6) -> tuple[float, ...]:
        """Round values within the scale, at steps of 1, 2 or 5 times a power of ten, at most that many."""
        rough = (self.high - self.low) / most
        power = 10.0 ** math.floor(math.log10(rough))
        step = next(power * factor for factor in (1, 2, 5, 10) if power * factor >= rough)
        first, last = math.ceil(self.low / step), math.floor(self.high / step)
        return tuple(index * step for index in range(first, last + 1))


def around(values: Iterable[float], start: float, end: float, always: tuple[float, ...] = (0.0, 1.0)) -> Axis:
    """A scale that holds the values and ``always``, with a little room at both ends."""
    held = [*values, *always]
    low, high = min(held), max(held)
    room = (high - low or 1.0) * 0.06
    return Axis(low - room, high + room, start, end)
