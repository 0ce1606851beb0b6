"""The floor and the runs of the reference agent on a task, as dots on the scale of returns."""

from __future__ import annotations

import statistics

from markupsafe import Markup

from gym_extensions.site.charts.scale import scale_around
from gym_extensions.site.charts.svg import picture, px, stroke, text, tick_label
from gym_extensions.site.text.numbers import digits_for, fixed
from gym_extensions.site.views.reference import Measured

WIDTH, MARGIN, LINE = 480, 24, 34


def reference_dots(measured: Measured) -> Markup:
    """The floor as a line marked 0, runs as dots, and their mean as a line, marked 1 if it is the ceiling."""
    values = [measured.floor, *measured.runs]
    scale = scale_around(values, MARGIN, WIDTH - MARGIN, always=())
    y, digits = LINE / 2 + 8, digits_for(values)
    parts = [stroke(scale.start, y, scale.end, y, "level")]
    parts += [text("tick", scale.at(mark), y + 24, tick_label(mark)) for mark in scale.ticks()]
    parts.append(stroke(scale.at(measured.floor), y - 9, scale.at(measured.floor), y + 9, "reference-floor"))
    parts.append(text("tick key", scale.at(measured.floor), y - 13, "0"))
    label = f"floor {fixed(measured.floor, digits)}"
    if measured.runs:
        mean = statistics.fmean(measured.runs)
        parts += [
            f'<circle class="run final" cx="{px(scale.at(run))}" cy="{px(y)}" r="4"/>'
            for run in measured.runs
        ]
        parts.append(stroke(scale.at(mean), y - 9, scale.at(mean), y + 9, "cell-mean"))
        if measured.ceiling is not None:
            parts.append(text("tick key", scale.at(mean), y - 13, "1"))
        agent = "runs of the reference agent" if measured.budget else measured.agent
        label += f"; {agent} {', '.join(fixed(run, digits) for run in measured.runs)}"
    return picture("references dots", str(WIDTH), px(y + 28), label, "".join(parts))
