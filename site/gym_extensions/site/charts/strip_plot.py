"""Drawings as inline SVG: pure functions from numbers to markup; colours come from the style sheet."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from markupsafe import Markup, escape

from gym_extensions.scoring.metrics.value import MetricValue
from gym_extensions.site.charts.scale import Axis, around
from gym_extensions.site.charts.svg import points, px, stroke, tick
from gym_extensions.site.text.numbers import fixed, interval

WIDTH, MARGIN = 280, 12
LANE = 22
UNMOVED = 0.005
"""A difference that two digits do not show; its line is neither a loss nor a gain."""


def estimate_axis(estimates: Iterable[MetricValue]) -> Axis:
    """One scale for strips that are read together: it holds every mean and every run, 0 and 1.

    Intervals may reach beyond it (two runs give wide ones); they are then drawn open at that end.
    """
    shown = [found for found in estimates if found.mean is not None]
    values = [value for found in shown for value in (found.mean, *found.runs) if value is not None]
    return around(values, MARGIN, WIDTH - MARGIN)


def said(estimate: MetricValue, digits: int = 2) -> str:
    """An estimate in words, for those who do not see the drawing."""
    if estimate.mean is None:
        return f"no value: {estimate.why}"
    ends = (
        f", 95 % interval {interval(*estimate.ends, digits)}" if estimate.ends else ", one run, no interval"
    )
    return f"{fixed(estimate.mean, digits)}{ends}"


def strip(estimate: MetricValue, axis: Axis) -> Markup:
    """One estimate on one line: interval as a bar, runs as dots, mean as a disc."""
    if estimate.mean is None:
        return Markup("")
    return _svg(LANE, said(estimate), _grid(axis, LANE) + _lane(estimate, axis, LANE / 2, "final"))


def slope(before: MetricValue, after: MetricValue, axis: Axis) -> Markup:
    """Two estimates, one under the other, joined: right after training each task above, at the end below.

    A line that leans to the left is what was forgotten on the way.
    """
    if before.mean is None or after.mean is None:
        return strip(after, axis)
    top, bottom, height = LANE / 2, LANE * 1.5 + 4, LANE * 2 + 4
    moved = after.mean - before.mean
    kind = "same" if abs(moved) < UNMOVED else "loss" if moved < 0 else "gain"
    joined = stroke(axis.at(before.mean), top, axis.at(after.mean), bottom, f"join {kind}")
    label = f"learning performance {said(before)}; final performance {said(after)}"
    lanes = _lane(before, axis, top, "learning") + _lane(after, axis, bottom, "final")
    return _svg(height, label, _grid(axis, height) + joined + lanes)


def example() -> Markup:
    """A drawing of made-up numbers, under its ruler, that explains the others."""
    learned = MetricValue(0.82, 0.72, 0.92, (0.75, 0.78, 0.83, 0.85, 0.89))
    left = MetricValue(0.47, 0.35, 0.59, (0.36, 0.43, 0.48, 0.52, 0.56))
    axis = Axis(-0.1, 1.1, MARGIN, WIDTH - MARGIN)
    return ruler(axis) + slope(learned, left, axis)


def ruler(axis: Axis) -> Markup:
    """The scale's numbers, to stand over a column of strips; 0 is the floor and 1 the reference."""
    marks = "".join(
        f'<text class="tick{" key" if mark in {0, 1} else ""}" x="{px(axis.at(mark))}" y="12">'
        f"{tick(mark)}</text>"
        for mark in sorted({*axis.ticks(5), 0.0, 1.0})
        if mark in {0.0, 1.0} or min(abs(axis.at(mark) - axis.at(key)) for key in (0.0, 1.0)) > 22
    )
    return Markup(f'<svg class="ruler" viewBox="0 0 {WIDTH} 16" aria-hidden="true">{marks}</svg>')


def panel(
    lines: Sequence[Sequence[tuple[float, float]]],
    x: Axis,
    y: Axis,
    label: str,
    *,
    bold: Sequence[tuple[float, float]] = (),
    since: float | None = None,
    levels: Sequence[float] = (),
) -> Markup:
    """A small chart: thin lines, one bold one, level lines across; what lies before ``since`` is shaded."""
    left, right, top, bottom = px(x.start), px(x.end), min(y.start, y.end), max(y.start, y.end)
    inside = [
        f'<line class="level" x1="{left}" x2="{right}" y1="{px(y.at(v))}" y2="{px(y.at(v))}"/>'
        for v in levels
    ]
    inside += [
        f'<text class="tick side" x="{px(x.start - 4)}" y="{px(y.at(v) + 3)}">{tick(v)}</text>'
        for v in levels
    ]
    if since is not None:
        inside.insert(
            0,
            f'<rect class="before" x="{left}" y="{px(top)}" width="{px(x.at(since) - x.start)}" '
            f'height="{px(bottom - top)}"/>',
        )
    inside += [f'<polyline class="thin" points="{points(line, x, y)}"/>' for line in lines]
    if bold:
        inside.append(f'<polyline class="bold" points="{points(bold, x, y)}"/>')
        inside += [
            f'<circle class="{"at" if at == since else "stop"}" cx="{px(x.at(at))}" cy="{px(y.at(value))}" '
            f'r="{4 if at == since else 2.2}"/>'
            for at, value in bold
        ]
    width, height = px(x.end + 8), px(bottom + 8)
    body = "".join(inside)
    return Markup(
        f'<svg class="panel" viewBox="0 0 {width} {height}" role="img" '
        f'aria-label="{escape(label)}">{body}</svg>'
    )


def _lane(estimate: MetricValue, axis: Axis, y: float, kind: str) -> str:
    parts = []
    if estimate.ends:
        low, high = (axis.at(end) for end in estimate.ends)
        parts.append(stroke(low, y, high, y, f"interval {kind}"))
        parts += [
            _arrow(axis.at(end), y, -1 if end < axis.low else 1, kind)
            for end in estimate.ends
            if not axis.holds(end)
        ]
    parts += [
        f'<circle class="run {kind}" cx="{px(axis.at(run))}" cy="{px(y)}" r="2.4">'
        f"<title>{fixed(run)}</title></circle>"
        for run in estimate.runs
    ]
    if estimate.mean is not None:
        parts.append(f'<circle class="mean {kind}" cx="{px(axis.at(estimate.mean))}" cy="{px(y)}" r="5"/>')
    return "".join(parts)


def _arrow(x: float, y: float, side: int, kind: str) -> str:
    corners = f"{px(x + 7 * side)},{px(y)} {px(x)},{px(y - 5)} {px(x)},{px(y + 5)}"
    return f'<polygon class="beyond {kind}" points="{corners}"/>'


def _grid(axis: Axis, height: float) -> str:
    return "".join(
        stroke(axis.at(mark), 0, axis.at(mark), height, f"grid {name}")
        for mark, name in ((0.0, "floor"), (1.0, "ceiling"))
    )


def _svg(height: float, label: str, body: str) -> Markup:
    return Markup(
        f'<svg class="strip" viewBox="0 0 {WIDTH} {px(height)}" role="img" '
        f'aria-label="{escape(label)}">{body}</svg>'
    )
