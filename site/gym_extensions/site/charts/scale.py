"""A linear scale from values to coordinates, with round ticks."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

PADDING = 0.06
"""Space at both ends of a scale, relative to the range of its values."""


@dataclass(frozen=True)
class Scale:
    """Maps ``low … high`` to the coordinates ``start … end``. Values outside are clipped."""

    low: float
    high: float
    start: float
    end: float

    def at(self, value: float) -> float:
        """The coordinate of a value, clipped to the scale."""
        share = (min(max(value, self.low), self.high) - self.low) / (self.high - self.low)
        return self.start + share * (self.end - self.start)

    def each_at(self, values: Sequence[float]) -> list[float]:
        """``at`` of every value."""
        low, start = self.low, self.start
        span, way = self.high - low, self.end - start
        return [start + (value - low) / span * way for value in self._clipped(values)]

    def all_at(self, values: Sequence[float]) -> list[float]:
        """As ``each_at`` and faster, but the last digits may differ."""
        slope = (self.end - self.start) / (self.high - self.low)
        offset = self.start - self.low * slope
        return [offset + value * slope for value in self._clipped(values)]

    def _clipped(self, values: Sequence[float]) -> Sequence[float]:
        if self.low <= min(values) and max(values) <= self.high:
            return values
        return [min(max(value, self.low), self.high) for value in values]

    def contains(self, value: float) -> bool:
        """Whether the value lies within the scale."""
        return self.low <= value <= self.high

    def ticks(self, most: int = 6) -> tuple[float, ...]:
        """At most ``most`` round values within the scale, at steps of 1, 2 or 5 times a power of ten."""
        rough = (self.high - self.low) / most
        power = 10.0 ** math.floor(math.log10(rough))
        step = next(power * factor for factor in (1, 2, 5, 10) if power * factor >= rough)
        first, last = math.ceil(self.low / step), math.floor(self.high / step)
        return tuple(index * step for index in range(first, last + 1))


def scale_around(
    values: Iterable[float], start: float, end: float, always: tuple[float, ...] = (0.0, 1.0)
) -> Scale:
    """A scale that contains the values and ``always``, with some padding."""
    contained = [*values, *always]
    low, high = min(contained), max(contained)
    padding = (high - low or 1.0) * PADDING
    return Scale(low - padding, high + padding, start, end)
