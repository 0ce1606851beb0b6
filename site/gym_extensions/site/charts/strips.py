"""Strip plots: a metric's mean, interval and runs on one line, alone or beside another metric."""

from collections.abc import Iterable, Sequence

from markupsafe import Markup

from gym_extensions.metrics.formulas import COLUMNS, LEARNING
from gym_extensions.metrics.values import MetricValue
from gym_extensions.scoring.ranking.boards import BoardMetric
from gym_extensions.site import submission_results, text
from gym_extensions.site.charts.svg import Scale, picture, px, scale_around, stroke, tick_label

WIDTH, MARGIN = 280, 12
ROW_HEIGHT = 22
NO_CHANGE = 0.005
"""A smaller difference is invisible at two digits; its line is neither a loss nor a gain."""
TICK_DISTANCE = 22
"""Minimum distance of a tick label from those of 0 and 1."""


Shown = MetricValue | BoardMetric
"""A value of a scorecard, with its runs, or of a board."""


def runs_of(value: Shown) -> tuple[float, ...]:
    """The values of the runs, which boards do not repeat."""
    return value.runs if isinstance(value, MetricValue) else ()


def metric_scale(values: Iterable[Shown]) -> Scale:
    """One scale for strips that are read together. It contains every mean and every run, 0 and 1.

    Intervals may exceed it, because those of two runs are wide; they then end in an arrow.
    """
    drawn = [value for value in values if value.mean is not None]
    numbers = [number for value in drawn for number in (value.mean, *runs_of(value)) if number is not None]
    return scale_around(numbers, MARGIN, WIDTH - MARGIN)


def board_scale(results: Sequence[submission_results.SubmissionResult]) -> Scale:
    """One scale for the drawn metrics of one protocol: the sorting one and learning performance."""
    drawn = [COLUMNS[result.protocol][0] for result in results[:1]] + [LEARNING.name]
    return metric_scale(result.metric(name) for result in results for name in drawn)


def describe(value: Shown) -> str:
    """A metric value in words, for screen readers."""
    if value.mean is None:
        return f"no value: {value.why}"
    alone = ", one run, no interval" if runs_of(value) else ", no interval"
    ends = f", 95 % interval {text.interval(*value.ends)}" if value.ends else alone
    return f"{text.fixed(value.mean)}{ends}"


def strip(value: Shown, scale: Scale) -> Markup:
    """One metric value on one line: interval as a bar, runs as dots, mean as a disc."""
    if value.mean is None:
        return Markup("")
    return _drawn(value, scale, describe(value))


def dumbbell(before: Shown, after: Shown, scale: Scale, *, described: bool = True) -> Markup:
    """Two metric values on one line: a ring right after the training, a disc with its interval at the end.

    A disc to the left of its ring shows forgetting. ``described``: for screen readers.
    """
    if before.mean is None or after.mean is None:
        return strip(after, scale)
    change, y = after.mean - before.mean, ROW_HEIGHT / 2
    kind = "same" if abs(change) < NO_CHANGE else "loss" if change < 0 else "gain"
    ring = f'<circle class="mean learning" cx="{px(scale.at(before.mean))}" cy="{px(y)}" r="4.5"/>'
    join = stroke(scale.at(before.mean), y, scale.at(after.mean), y, f"join {kind}")
    label = f"learned {describe(before)}; at the end {describe(after)}" if described else ""
    return _drawn(after, scale, label, join + ring)


def ruler(scale: Scale) -> Markup:
    """The tick labels above a column of strips, with 0 (floor) and 1 (expert) where the scale has them."""
    marks = "".join(
        f'<text class="tick{" key" if mark in {0, 1} else ""}" x="{px(scale.at(mark))}" y="12">'
        f"{tick_label(mark)}</text>"
        for mark in sorted({*scale.ticks(5), *filter(scale.contains, (0.0, 1.0))})
        if mark in {0.0, 1.0}
        or min(abs(scale.at(mark) - scale.at(key)) for key in (0.0, 1.0)) > TICK_DISTANCE
    )
    return picture("ruler", str(WIDTH), "16", "", marks)


def _drawn(value: Shown, scale: Scale, label: str, before: str = "") -> Markup:
    """The interval, runs and mean of a value on the grid, above what stands ``before``."""
    y = ROW_HEIGHT / 2
    parts = [
        stroke(scale.at(mark), 0, scale.at(mark), ROW_HEIGHT, f"grid {name}")
        for mark, name in ((0.0, "floor"), (1.0, "expert"))
        if scale.contains(mark)
    ]
    parts.append(before)
    if value.ends:
        low, high = (scale.at(end) for end in value.ends)
        parts.append(stroke(low, y, high, y, "interval"))
        for end in value.ends:
            if not scale.contains(end):  # an arrow
                x, tip = scale.at(end), -7 if end < scale.low else 7
                corners = f"{px(x + tip)},{px(y)} {px(x)},{px(y - 5)} {px(x)},{px(y + 5)}"
                parts.append(f'<polygon class="beyond" points="{corners}"/>')
    runs = runs_of(value)
    parts += [
        f'<circle class="run" cx="{px(x)}" cy="{px(y)}" r="2.4"><title>{text.fixed(run)}</title></circle>'
        for run, x in zip(runs, scale.each_at(runs) if runs else (), strict=True)
    ]
    if value.mean is not None:
        parts.append(f'<circle class="mean" cx="{px(scale.at(value.mean))}" cy="{px(y)}" r="5"/>')
    return picture("strip", str(WIDTH), px(ROW_HEIGHT), label, "".join(parts))
