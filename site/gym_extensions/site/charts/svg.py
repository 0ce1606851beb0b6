"""SVG that the charts share: scales with round ticks, lines, discs, texts and the picture itself."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from markupsafe import Markup, escape

from gym_extensions.site.text import fixed

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
        slope = (self.end - self.start) / (self.high - self.low)
        offset = self.start - self.low * slope
        if not self.low <= min(values) <= max(values) <= self.high:
            values = [min(max(value, self.low), self.high) for value in values]
        return [offset + value * slope for value in values]

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


def px(value: float) -> str:
    """A coordinate with at most one digit after the point, in ASCII."""
    return f"{value:.1f}".replace("-0.0", "0.0").removesuffix(".0")


def picture(kind: str, width: float, height: float, label: str, body: str, *, drawn: str = "") -> Markup:
    """An ``svg`` element of class ``kind`` with a label for screen readers, which do not see one without.

    ``drawn``: further attributes, with a space before the first.
    """
    read = f'role="img" aria-label="{escape(label)}"' if label else 'aria-hidden="true"'
    return Markup(f'<svg class="{kind}" viewBox="0 0 {px(width)} {px(height)}" {read}{drawn}>{body}</svg>')


def stroke(x1: float, y1: float, x2: float, y2: float, kind: str) -> str:
    """A straight line of class ``kind``."""
    return f'<line class="{kind}" x1="{px(x1)}" y1="{px(y1)}" x2="{px(x2)}" y2="{px(y2)}"/>'


def disc(kind: str, x: float, y: float, radius: float, title: str = "") -> str:
    """A disc of class ``kind``; its title, which is not escaped, is its tooltip."""
    end = f"><title>{title}</title></circle>" if title else "/>"
    return f'<circle class="{kind}" cx="{px(x)}" cy="{px(y)}" r="{px(radius)}"{end}'


def text(kind: str, x: float, y: float, content: str) -> str:
    """A text of class ``kind``; ``content`` is not escaped."""
    return f'<text class="{kind}" x="{px(x)}" y="{px(y)}">{content}</text>'


def points(line: Iterable[tuple[float, float]], x: Scale, y: Scale) -> str:
    """The ``points`` of a polyline through these values, clipped to the scales."""
    across, up = zip(*line, strict=True)
    pairs = [0.0] * (2 * len(across))
    pairs[::2], pairs[1::2] = x.each_at(across), y.each_at(up)
    # One operation for all numbers: large boards have millions of points.
    return (("%.1f,%.1f " * len(across)) % tuple(pairs)).rstrip().replace("-0.0", "0.0")


def tick_label(value: float) -> str:
    """The number at a tick: two digits after the point below 10, without trailing zeros."""
    label = fixed(value, 2 if abs(value) < 10 else 0)
    return label.rstrip("0").rstrip(".") if "." in label else label


LABEL_DISTANCE = 11.0
"""Minimum distance of two labels of a vertical scale, in pixels."""


def apart(levels: Iterable[float], scale: Scale) -> list[float]:
    """The levels on the scale whose labels do not overlap those of earlier ones."""
    placed: list[float] = []
    for level in levels:
        if scale.contains(level) and all(
            abs(scale.at(level) - scale.at(other)) >= LABEL_DISTANCE for other in placed
        ):
            placed.append(level)
    return placed
