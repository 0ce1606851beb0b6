"""SVG elements that the charts share: coordinates, lines, texts, tick labels and the picture itself."""

from __future__ import annotations

from collections.abc import Iterable

from markupsafe import Markup, escape

from gym_extensions.site.charts.scale import Scale
from gym_extensions.site.text.numbers import fixed


def px(value: float) -> str:
    """A coordinate with one digit after the point, in ASCII."""
    return f"{value:.1f}".replace("-0.0", "0.0")


def picture(kind: str, width: str, height: str, label: str, body: str) -> Markup:
    """An ``svg`` element of class ``kind`` with a label for screen readers.

    Args:
        kind: the class in the style sheet.
        width: the width of the view box.
        height: the height of the view box.
        label: the chart in words; it is escaped.
        body: the elements inside, as markup.
    """
    return Markup(
        f'<svg class="{kind}" viewBox="0 0 {width} {height}" role="img" '
        f'aria-label="{escape(label)}">{body}</svg>'
    )


def stroke(x1: float, y1: float, x2: float, y2: float, kind: str) -> str:
    """A straight line of class ``kind``."""
    return f'<line class="{kind}" x1="{px(x1)}" y1="{px(y1)}" x2="{px(x2)}" y2="{px(y2)}"/>'


def text(kind: str, x: float, y: float, content: str) -> str:
    """A text of class ``kind``; ``content`` is not escaped."""
    return f'<text class="{kind}" x="{px(x)}" y="{px(y)}">{content}</text>'


def points(line: Iterable[tuple[float, float]], x: Scale, y: Scale) -> str:
    """The ``points`` of a polyline through these values, clipped to the scales."""
    across, up = zip(*line, strict=True)
    pairs = [0.0] * (2 * len(across))
    pairs[::2], pairs[1::2] = x.all_at(across), y.all_at(up)
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
