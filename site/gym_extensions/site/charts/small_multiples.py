"""Small multiples of a trial: one line chart per task, on shared scales."""

from __future__ import annotations

import math
from dataclasses import dataclass

from markupsafe import Markup

from gym_extensions.site.charts.line_chart import line_chart
from gym_extensions.site.charts.scale import Scale, scale_around
from gym_extensions.site.text.names import variation
from gym_extensions.site.text.numbers import fixed, grouped
from gym_extensions.site.views.trial import Trial

X = (34.0, 200.0)
Y = (100.0, 10.0)


@dataclass(frozen=True)
class Panel:
    """A chart with its title; ``unit`` says what a scale counts, where that is not obvious."""

    title: Markup
    unit: str
    drawing: Markup


def histories(trial: Trial) -> list[Panel]:
    """Per task, its score after every stage: a line per run, the mean bold, the trained stage marked.

    Tasks with a ceiling share one scale of normalized returns. An unsolved task has a scale of raw returns.
    """
    normalized = [_normalized(trial, task) for task in range(len(trial.tasks))]
    shared = scale_around((score for scores in normalized if scores for score in scores), *Y)
    return [_history(trial, task, scores, shared) for task, scores in enumerate(normalized)]


def _raw(trial: Trial, task: int) -> list[float]:
    """Mean returns of a task by run and stage, flattened."""
    return [stage[task] for run in trial.stage_matrices for stage in run]


def _normalized(trial: Trial, task: int) -> list[float] | None:
    """Scores of a task by run and stage, flattened; None without a ceiling."""
    reference = trial.reference(trial.tasks[task])
    scores = [reference.normalize(value) for value in _raw(trial, task)] if reference else [None]
    present = [score for score in scores if score is not None]
    return present if len(present) == len(scores) else None


def _history(trial: Trial, task: int, normalized: list[float] | None, shared: Scale) -> Panel:
    raw = _raw(trial, task)
    values = raw if normalized is None else normalized
    y = scale_around(raw, *Y, always=()) if normalized is None else shared
    stages = len(trial.tasks) + 1
    x = Scale(0, stages - 1, *X)
    lines = [
        [(float(stage), values[run * stages + stage]) for stage in range(stages)]
        for run in range(len(trial.stage_matrices))
    ]
    mean = [(at, math.fsum(line[int(at)][1] for line in lines) / len(lines)) for at, _ in lines[0]]
    trained = task + 1
    shown = [fixed(mean[stage][1], 0 if normalized is None else 2) for stage in (0, trained, -1)]
    label = (
        f"{trial.tasks[task]}: {shown[0]} untrained, {shown[1]} right after its training, "
        f"{shown[2]} at the end"
    )
    levels = (min(raw), max(raw)) if normalized is None else (0.0, 1.0, max(y.ticks(4)))
    drawing = line_chart(lines, x, y, label, bold=mean, since=float(trained), levels=levels)
    unit = f"raw return{' (unsolved)' if trial.tasks[task] in trial.unsolved_tasks else ''}"
    unit = unit if normalized is None else ""
    return Panel(variation(trial.tasks[task], trial.tasks), unit, drawing)


def curves(trial: Trial) -> list[Panel]:
    """Per task with training curves, its raw returns over steps; one scale per group."""
    group_curves = trial.detail.curves if trial.detail else ()
    points = [point for curve in group_curves for point in curve.points]
    if not points:
        return []
    steps, values = zip(*points, strict=True)
    y = scale_around(values, *Y, always=())
    last = max(steps)
    x = Scale(0, last or 1.0, *X)
    levels = (min(values), max(values))
    panels = []
    for task in trial.tasks:
        lines = [curve.points for curve in group_curves if curve.task == task]
        if lines:
            final = ", ".join(fixed(line[-1][1], 0) for line in lines if line)
            label = f"{task}: training returns, at the end {final}"
            drawing = line_chart(lines, x, y, label, levels=levels)
            panels.append(Panel(variation(task, trial.tasks), f"{grouped(int(last))} steps", drawing))
    return panels
