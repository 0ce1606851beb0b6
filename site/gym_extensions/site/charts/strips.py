"""Strip plots: a metric's mean, interval and runs on one line, alone or beside another metric."""

from collections.abc import Iterable, Sequence

from markupsafe import Markup

from gym_extensions.metrics.formulas import COLUMNS, LEARNING
from gym_extensions.metrics.values import MetricValue
from gym_extensions.scoring.ranking.boards import BoardMetric
from gym_extensions.site import submission_results, text
from gym_extensions.site.charts import svg

WIDTH, MARGIN = 280, 12
ROW_HEIGHT = 22
NO_CHANGE = 0.005
"""A smaller difference is invisible at two digits; its line is neither a loss nor a gain."""
TICK_DISTANCE = 22
"""Minimum distance of a tick label from those of 0 and 1."""


AnyMetric = MetricValue | BoardMetric
"""A value of a scorecard, with its runs, or of a board."""


def runs_of(value: AnyMetric) -> tuple[float, ...]:
    """The values of the runs, which boards do not repeat."""
    return value.runs if isinstance(value, MetricValue) else ()


def metric_scale(values: Iterable[AnyMetric]) -> svg.Scale:
    """One scale for strips that are read together. It contains every mean and every run, 0 and 1.

    Intervals may exceed it, because those of two runs are wide; they then end in an arrow.
    """
    numbers = [
        number for value in values if value.mean is not None for number in (value.mean, *runs_of(value))
    ]
    return svg.scale_around(numbers, MARGIN, WIDTH - MARGIN)


def board_scale(results: Sequence[submission_results.SubmissionResult]) -> svg.Scale:
    """One scale for the drawn metrics of one protocol: the sorting one and learning performance."""
    drawn = [COLUMNS[result.protocol][0] for result in results[:1]] + [LEARNING.name]
    return metric_scale(result.metric(name) for result in results for name in drawn)


def describe(value: AnyMetric) -> str:
    """A metric value in words, for screen readers."""
    alone = ", one run, no interval" if runs_of(value) else ", no interval"
    ends = f", 95 % interval {text.interval(*value.ends)}" if value.ends else alone
    return f"{text.mean(value)}{ends}"


def strip(value: AnyMetric, scale: svg.Scale) -> Markup:
    """One metric value on one line: interval as a bar, runs as dots, mean as a disc; empty without a mean."""
    return _drawn(value, scale, describe(value))


def dumbbell(before: AnyMetric, after: AnyMetric, scale: svg.Scale, *, described: bool = True) -> Markup:
    """Two metric values on one line: a ring right after the training, a disc with its interval at the end.

    A disc to the left of its ring shows forgetting. ``described``: for screen readers.
    """
    if before.mean is None or after.mean is None:
        return strip(after, scale)
    change, y = after.mean - before.mean, ROW_HEIGHT / 2
    kind = "same" if abs(change) < NO_CHANGE else "loss" if change < 0 else "gain"
    ring = svg.disc("mean learning", scale.at(before.mean), y, 4.5)
    join = svg.stroke(scale.at(before.mean), y, scale.at(after.mean), y, f"join {kind}")
    label = f"learned {describe(before)}; at the end {describe(after)}" if described else ""
    return _drawn(after, scale, label, join + ring)


def ruler(scale: svg.Scale) -> Markup:
    """The tick labels above a column of strips, with 0 (floor) and 1 (expert) where the scale has them."""
    keys = [mark for mark in (0.0, 1.0) if scale.contains(mark)]
    others = [
        mark
        for mark in scale.ticks(5)
        if all(abs(scale.at(mark) - scale.at(key)) > TICK_DISTANCE for key in (0.0, 1.0))
    ]
    marks = (
        svg.text("tick key" if mark in keys else "tick", scale.at(mark), 12, svg.tick_label(mark))
        for mark in sorted(keys + others)
    )
    return svg.picture("ruler", WIDTH, 16, "", "".join(marks))


def _drawn(value: AnyMetric, scale: svg.Scale, label: str, before: str = "") -> Markup:
    """The interval, runs and mean of a value on the grid, above what stands ``before``."""
    if value.mean is None:
        return Markup("")
    y = ROW_HEIGHT / 2
    parts = [
        svg.stroke(scale.at(mark), 0, scale.at(mark), ROW_HEIGHT, f"grid {name}")
        for mark, name in ((0.0, "floor"), (1.0, "expert"))
        if scale.contains(mark)
    ]
    parts.append(before)
    if value.ends:
        low, high = (scale.at(end) for end in value.ends)
        parts.append(svg.stroke(low, y, high, y, "interval"))
        for end in value.ends:
            if not scale.contains(end):  # an arrow
                x, tip = scale.at(end), -7 if end < scale.low else 7
                corners = ((x + tip, y), (x, y - 5), (x, y + 5))
                drawn = " ".join(f"{svg.px(left)},{svg.px(up)}" for left, up in corners)
                parts.append(f'<polygon class="beyond" points="{drawn}"/>')
    parts += [svg.disc("run", scale.at(run), y, 2.4, text.fixed(run)) for run in runs_of(value)]
    parts.append(svg.disc("mean", scale.at(value.mean), y, 5))
    return svg.picture("strip", WIDTH, ROW_HEIGHT, label, "".join(parts))
