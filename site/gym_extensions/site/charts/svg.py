"""The small parts of every drawing: coordinates, lines, the numbers of a scale."""

from __future__ import annotations

from collections.abc import Iterable

from gym_extensions.site.charts.scale import Axis
from gym_extensions.site.text.numbers import fixed


def px(value: float) -> str:
    """A coordinate: one digit after the point, ASCII."""
    return f"{value:.1f}".replace("-0.0", "0.0")


def stroke(x1: float, y1: float, x2: float, y2: float, kind: str) -> str:
    """A straight line of that class."""
    return f'<line class="{kind}" x1="{px(x1)}" y1="{px(y1)}" x2="{px(x2)}" y2="{px(y2)}"/>'


def points(line: Iterable[tuple[float, float]], x: Axis, y: Axis) -> str:
    """What a polyline goes through, by two scales."""
    return " ".join(f"{px(x.at(across))},{px(y.at(up))}" for across, up in line)


def tick(value: float) -> str:
    """A number of a scale: two digits after the point where it is small, without trailing zeros."""
    text = fixed(value, 2 if abs(value) < 10 else 0)
    return text.rstrip("0").rstrip(".") if "." in text else text
