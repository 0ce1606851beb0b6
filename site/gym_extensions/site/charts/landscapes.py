"""Landscapes as heat maps: worlds across, stages down, with the returns after the last stage below."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby, pairwise

from markupsafe import Markup

from gym_extensions.catalog.worlds import Axis
from gym_extensions.site.charts import svg
from gym_extensions.site.charts.svg import px
from gym_extensions.site.text import fixed, grouped

TINTS = 10
"""Steps of the tint, from 0 to the best return."""
LEFT, RIGHT, TOP, ROW = 76.0, 404.0, 18.0, 20.0
"""Edges of the map and height of a stage."""
GAP, PROFILE, BELOW = 14.0, 84.0, 32.0
"""Space below the map, height of the returns, and space for their ticks and title."""
SMALL_WIDTH, SMALL_ROW = 150.0, 10.0
TICK_DISTANCE = 21.0
"""Minimum distance of labels across."""
Shares = Sequence[Sequence[float | None]]
"""[stage][point] as a share of the best return; None where there is no share."""


@dataclass(frozen=True)
class Frame:
    """Where a map is: the scale across, the edges of the columns, its top and the height of a stage."""

    x: svg.Scale
    edges: tuple[float, ...]
    top: float
    row: float

    @classmethod
    def of(cls, axis: Axis, left: float, right: float, top: float, row: float) -> Frame:
        """The frame of an axis; a column reaches halfway to its neighbours."""
        values = axis.points
        middles = [(low + high) / 2 for low, high in pairwise(values)]
        first, last = 2 * values[0] - middles[0], 2 * values[-1] - middles[-1]
        x = svg.Scale(first, last, left, right)
        return cls(x, tuple(map(x.at, (first, *middles, last))), top, row)

    def y(self, stage: float) -> float:
        """The upper edge of a stage."""
        return self.top + stage * self.row


def _map(axis: Axis, shares: Shares, frame: Frame, dots: tuple[float, float]) -> str:
    """The cells, one path per tint, and the trained values: large right after their stage, small later.

    Neighbours of one tint are one cell. Cells are strokes as wide as a stage, those of the most frequent tint
    a ground, and dots those of a dashed line, so that a page with many maps stays small.
    """
    cells: dict[str, list[str]] = {}
    for stage, row in enumerate(shares):
        tints = [
            "unknown" if share is None else f"t{round(TINTS * min(max(share, 0.0), 1.0))}" for share in row
        ]
        for kind, members in groupby(range(len(row)), key=tints.__getitem__):
            first, *others = members
            left, right = frame.edges[first], frame.edges[first + len(others) + 1]
            way = f"M{round(left)} {px(frame.y(stage + 0.5))}H{round(right)}"
            cells.setdefault(kind, []).append(way)
    ground = max(cells, key=lambda kind: len(cells[kind]))
    del cells[ground]  # the most frequent tint is one stroke below the others
    left, right, height = frame.edges[0], frame.edges[-1], frame.row * len(shares)
    whole = f"M{px(left)} {px(frame.top + height / 2)}H{px(right)}"
    drawn = "".join(f'<path class="{kind}" d="{"".join(ways)}"/>' for kind, ways in sorted(cells.items()))
    body = [f'<path class="{ground}" stroke-width="{px(height)}" d="{whole}"/>']
    body += [f'<g stroke-width="{frame.row:g}">{drawn}</g><g stroke-dasharray="0 {frame.row:g}">']
    for size, is_now in zip(dots, (False, True), strict=True):
        marks: list[str] = []
        for each in axis.trained:
            first = each.task + (1 if is_now else 2)
            last = first if is_now else len(shares) - 1
            marks += [
                f"M{px(frame.x.at(value))} {px(frame.y(first + 0.5))}v{px((last - first) * frame.row + 1)}"
                for value in axis.points
                if each.low <= value <= each.high and first <= last < len(shares)
            ]
        body += [
            f'<path class="{kind}" stroke-width="{width:g}" d="{"".join(marks)}"/>'
            for kind, width in (("halo", size + 2), ("seen", size))
            if marks
        ]
    return "".join([*body, "</g>"])


def small(axis: Axis, shares: Shares, label: str) -> Markup:
    """The map of one run, without ticks."""
    frame = Frame.of(axis, 0.0, SMALL_WIDTH, 0.0, SMALL_ROW)
    height = frame.y(len(shares))
    return svg.picture(
        "landscape small", px(SMALL_WIDTH), px(height), label, _map(axis, shares, frame, (2, 5))
    )


def large(
    axis: Axis,
    shares: Shares,
    stages: Sequence[str],
    returns: Sequence[Sequence[float]],
    mean: Sequence[float],
    *,
    best: Sequence[float],
) -> Markup:
    """The map of the mean over runs, and the returns of the runs after the last stage below it.

    Args:
        axis: what is varied.
        shares: the mean shares.
        stages: the name of every stage.
        returns: [run][point] after the last stage.
        mean: their mean over runs.
        best: the best mean return at every point.
    """
    frame = Frame.of(axis, LEFT, RIGHT, TOP, ROW)
    bottom = frame.y(len(shares))
    low = bottom + GAP + PROFILE
    y = svg.scale_around(
        [*best, *(value for run in returns for value in run)], low, bottom + GAP, always=(0.0,)
    )
    body = [_map(axis, shares, frame, (3, 7.5))]
    body.append(svg.text("tick side", LEFT - 6, TOP - 7, "after training"))
    body += [svg.text("tick side", LEFT - 6, frame.y(at + 0.5) + 3.5, name) for at, name in enumerate(stages)]
    trained = [value for value in axis.points if axis.place(value) == "trained"]
    body += [svg.stroke(frame.x.at(at), bottom + 3, frame.x.at(at), low, "level") for at in trained]
    body += [svg.stroke(LEFT, y.at(at), RIGHT, y.at(at), "level") for at in y.ticks(3)]
    body += [
        svg.text("tick side", LEFT - 6, y.at(at) + 3.5, grouped(round(at)))
        for at in svg.apart(y.ticks(3), y)
        if y.at(at) > bottom + GAP + 12
    ]
    across = list(axis.points)
    for kind, line in (*(("thin", run) for run in returns), ("best", best), ("bold", mean)):
        body.append(
            f'<polyline class="{kind}" points="{svg.points(zip(across, line, strict=True), frame.x, y)}"/>'
        )
    body.append(svg.text("tick side", LEFT - 6, bottom + GAP + 2, "return"))
    body += _ticks(axis, frame, trained, low + 13)
    body.append(svg.text("tick", (LEFT + RIGHT) / 2, low + 28, f"{axis.title} ({axis.unit})"))
    return svg.picture("landscape", px(RIGHT + 6), px(low + BELOW), describe(axis, mean, best), "".join(body))


def _ticks(axis: Axis, frame: Frame, trained: Sequence[float], y: float) -> list[str]:
    """Labels of the trained values in bold, and of both ends, where they do not overlap."""
    placed: list[float] = []
    labels = []
    for value in (axis.points[0], axis.points[-1], trained[0], trained[-1], *trained):
        at = frame.x.at(value)
        if all(abs(at - other) >= TICK_DISTANCE for other in placed):
            placed.append(at)
            labels.append(svg.text("tick key" if value in trained else "tick", at, y, svg.tick_label(value)))
    return labels


def describe(axis: Axis, mean: Sequence[float], best: Sequence[float]) -> str:
    """The returns after the last stage in words: at both ends and at the trained values."""
    parts = [
        f"{fixed(at, 0)} at {svg.tick_label(value)} {axis.unit}{' (trained)' if is_trained else ''}, "
        f"best of all submissions {fixed(top, 0)}"
        for value, at, top in zip(axis.points, mean, best, strict=True)
        if (is_trained := axis.place(value) == "trained") or value in (axis.points[0], axis.points[-1])
    ]
    return f"Mean return after the last stage by {axis.title}: {'; '.join(parts)}"


def scale() -> Markup:
    """The legend of the tint."""
    width = 14
    cells = "".join(
        f'<path class="t{tint}" stroke-width="10" d="M{tint * width} 5h{width}"/>'
        for tint in range(TINTS + 1)
    )
    box = f"0 0 {width * (TINTS + 1)} 10"
    return Markup(f'<svg class="landscape tints" viewBox="{box}" aria-hidden="true">{cells}</svg>')
