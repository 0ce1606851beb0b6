"""Scores through the sequence: per task, the mean and interval of some entries after every stage."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice

from markupsafe import Markup

from gym_extensions.site.charts.performance_profile import LINE_STYLES
from gym_extensions.site.charts.scale import Scale, scale_around
from gym_extensions.site.charts.svg import apart, picture, points, px, stroke, text, tick_label
from gym_extensions.site.text.names import short, variation
from gym_extensions.site.text.numbers import fixed
from gym_extensions.site.views.board_row import Row
from gym_extensions.site.views.retention import Retention

X = (34.0, 200.0)
Y = (100.0, 10.0)
WIDTH, HEIGHT = 208, 108
REACH = 0.5
"""How far intervals may extend the scale beyond the means, relative to their range."""


@dataclass(frozen=True)
class Drawn:
    """An entry on the charts: its class in the style sheet, its title and name, its scores."""

    kind: str
    title: str
    name: str
    retention: Retention

    @property
    def sample(self) -> Markup:
        """A piece of its line, for the legend."""
        body = stroke(0, 4, 26, 4, f"line {self.kind}")
        return Markup(f'<svg class="sample" viewBox="0 0 26 8" aria-hidden="true">{body}</svg>')


def drawn(rows: Sequence[Row], most: int = LINE_STYLES) -> list[Drawn]:
    """The first entries that have scores over the sequence."""
    with_stages = ((row, row.retention) for row in rows if row.retention and row.retention.stages)
    return [
        Drawn(f"p{number}", row.entry.title, row.entry.name, retention)
        for number, (row, retention) in enumerate(islice(with_stages, most), 1)
    ]


def panels(lines: Sequence[Drawn]) -> list[tuple[Markup, Markup]]:
    """Title and chart of every task that has scores, on one scale."""
    if not lines:
        return []
    tasks = lines[0].retention.tasks
    means = [
        value.mean
        for line in lines
        for stage in line.retention.stages
        for value in stage
        if value.mean is not None
    ]
    if not means:
        return []
    y = scale_around(means, *Y)
    x = Scale(0, len(tasks), *X)
    return [
        (variation(task, tasks), _panel(lines, at, x, y))
        for at, task in enumerate(tasks)
        if lines[0].retention.stages[0][at].mean is not None
    ]


def _panel(lines: Sequence[Drawn], at: int, x: Scale, y: Scale) -> Markup:
    top, bottom = min(y.start, y.end), max(y.start, y.end)
    width = px(x.at(at + 1) - x.start)
    body = [
        f'<rect class="before" x="{px(x.start)}" y="{px(top)}" width="{width}" height="{px(bottom - top)}"/>'
    ]
    for level in (0.0, 1.0):
        body.append(stroke(x.start, y.at(level), x.end, y.at(level), "level"))
    body += [
        text("tick side", x.start - 4, y.at(level) + 3, tick_label(level))
        for level in apart((0.0, 1.0, *reversed(y.ticks(4))), y)
    ]
    labels = []
    for line in reversed(lines):
        values = [stage[at] for stage in line.retention.stages]
        mean = [(float(stage), value.mean) for stage, value in enumerate(values) if value.mean is not None]
        if not mean:
            continue
        low = [(float(stage), value.ends[0]) for stage, value in enumerate(values) if value.ends]
        high = [(float(stage), value.ends[1]) for stage, value in enumerate(values) if value.ends]
        if low:
            body.append(
                f'<polygon class="band {line.kind}" points="{points([*low, *reversed(high)], x, y)}"/>'
            )
        body.append(f'<polyline class="line {line.kind}" points="{points(mean, x, y)}"/>')
        after, end = mean[min(at + 1, len(mean) - 1)][1], mean[-1][1]
        labels.append(
            f"{short(line.title)} ({line.name}): {fixed(after)} right after its training, "
            f"{fixed(end)} at the end"
        )
    return picture("panel", str(WIDTH), str(HEIGHT), "; ".join(reversed(labels)), "".join(body))
