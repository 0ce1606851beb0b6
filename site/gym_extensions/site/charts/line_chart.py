"""A small line chart: a thin line per run and a bold line for their mean."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from operator import sub

from markupsafe import Markup

from gym_extensions.site.charts.scale import Scale
from gym_extensions.site.charts.svg import apart, picture, points, px, text, tick_label

MARGIN = 8
THIN_UNITS = 2
"""Units per pixel of thin lines: whole numbers of half pixels take half the bytes of coordinates."""


def line_chart(
    lines: Sequence[Sequence[tuple[float, float]]],
    x: Scale,
    y: Scale,
    label: str,
    *,
    bold: Sequence[tuple[float, float]] = (),
    since: float | None = None,
    levels: Sequence[float] = (),
) -> Markup:
    """The chart as an ``svg`` element.

    Args:
        lines: thin lines, as points (x, y).
        x: horizontal scale.
        y: vertical scale.
        label: the chart in words.
        bold: the bold line, with a dot per point.
        since: the area left of this x is shaded, and the dot at it is large.
        levels: horizontal lines, labelled where labels do not overlap, the first ones first.
    """
    left, right, top, bottom = px(x.start), px(x.end), min(y.start, y.end), max(y.start, y.end)
    body = []
    if since is not None:
        width = px(x.at(since) - x.start)
        body.append(
            f'<rect class="before" x="{left}" y="{px(top)}" width="{width}" height="{px(bottom - top)}"/>'
        )
    body += [
        f'<line class="level" x1="{left}" x2="{right}" y1="{px(y.at(v))}" y2="{px(y.at(v))}"/>'
        for v in levels
    ]
    body += [text("tick side", x.start - 4, y.at(v) + 3, tick_label(v)) for v in apart(levels, y)]
    scale = f'transform="scale({1 / THIN_UNITS:g})"'
    body += [f'<path class="thin" {scale} d="{_path(line, x, y)}"/>' for line in lines if line]
    if bold:
        body.append(f'<polyline class="bold" points="{points(bold, x, y)}"/>')
        body += [
            f'<circle class="{"at" if at == since else "stop"}" cx="{px(x.at(at))}" cy="{px(y.at(value))}" '
            f'r="{4 if at == since else 2.2}"/>'
            for at, value in bold
        ]
    return picture("panel", px(x.end + MARGIN), px(bottom + MARGIN), label, "".join(body))


def _path(line: Sequence[tuple[float, float]], x: Scale, y: Scale) -> str:
    """The path of a thin line: its first point, then the way to each further one."""
    columns, rows = zip(*line, strict=True)
    (left, *across), (top, *up) = _steps(columns, x), _steps.__wrapped__(rows, y)
    steps = [""] * (2 * len(across))
    steps[::2], steps[1::2] = across, up
    way = f"l{' '.join(steps)}" if steps else "h0"
    return f"M{left} {top}{way}".replace(" -", "-")


@lru_cache(maxsize=8)
def _steps(values: tuple[float, ...], scale: Scale) -> tuple[str, ...]:
    """The first coordinate, then the way to each further one. The runs of a chart share those of x."""
    corners = [round(THIN_UNITS * at) for at in scale.each_at(values)]
    return tuple(map(str, (corners[0], *map(sub, corners[1:], corners))))
