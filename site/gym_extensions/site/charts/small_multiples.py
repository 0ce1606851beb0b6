"""Small multiples of a trial: one small chart a task, on scales that all of them share."""

from __future__ import annotations

import math
from dataclasses import dataclass

from markupsafe import Markup

from gym_extensions.scoring.metrics.value import LEAST_LEARNED
from gym_extensions.scoring.scorecard.model import ReferenceValue
from gym_extensions.scoring.statistics.intervals import interval
from gym_extensions.site.charts import heatmap as heat
from gym_extensions.site.charts import strip_plot as charts
from gym_extensions.site.charts.scale import Axis, around
from gym_extensions.site.text import labels as words
from gym_extensions.site.text.numbers import fixed, grouped
from gym_extensions.site.views.trial import Trial

LITTLE_LOST = 0.05
X = (34.0, 200.0)
Y = (100.0, 10.0)


@dataclass(frozen=True)
class Panel:
    """A chart with its title; ``unit`` says what the upright scale counts, if that needs saying."""

    title: Markup
    unit: str
    drawing: Markup


def histories(trial: Trial) -> list[Panel]:
    """For each task, its score after every stage: a line a run, the mean bold, marked where it was trained.

    Tasks with a ceiling share one scale of normalized returns; an unsolved task has its own, of raw returns.
    """
    shared = around((value for task in range(len(trial.tasks)) for value in _scores(trial, task)[0]), *Y)
    return [_history(trial, task, shared) for task in range(len(trial.tasks))]


def _scores(trial: Trial, task: int) -> tuple[list[float], bool]:
    """All scores of a task, normalized where it has a ceiling, and whether it has one (else none)."""
    reference = _reference(trial, trial.tasks[task])
    raw = [stage[task] for run in trial.stage_matrices for stage in run]
    shares = [reference.normalize(value) for value in raw] if reference else [None]
    closed = [share for share in shares if share is not None]
    return (closed, True) if len(closed) == len(raw) else ([], False)


def _reference(trial: Trial, task: str) -> ReferenceValue | None:
    return trial.detail.reference.get(task) if trial.detail else None


def _history(trial: Trial, task: int, shared: Axis) -> Panel:
    scores, closed = _scores(trial, task)
    raw = [stage[task] for run in trial.stage_matrices for stage in run]
    values = scores if closed else raw
    y = shared if closed else around(raw, *Y, always=())
    stages = len(trial.tasks) + 1
    x = Axis(0, stages - 1, *X)
    lines = [
        [(float(stage), values[run * stages + stage]) for stage in range(stages)]
        for run in range(len(trial.stage_matrices))
    ]
    mean = [(at, math.fsum(line[int(at)][1] for line in lines) / len(lines)) for at, _ in lines[0]]
    trained = task + 1
    then = [fixed(mean[stage][1], 2 if closed else 0) for stage in (0, trained, -1)]
    label = (
        f"{trial.tasks[task]}: {then[0]} untrained, {then[1]} right after its training, {then[2]} at the end"
    )
    levels = (0.0, 1.0) if closed else (min(raw), max(raw))
    drawing = charts.panel(lines, x, y, label, bold=mean, since=float(trained), levels=levels)
    return Panel(
        words.variation(trial.tasks[task], trial.tasks), "" if closed else "raw return (unsolved)", drawing
    )


@dataclass(frozen=True)
class Lost:
    """A task's mean raw return right after its training, and at the end."""

    task: str
    before: float
    after: float


def most_lost(trial: Trial) -> Lost | None:
    """The task with a ceiling that lost most of its normalized return, mean over runs; None if under .05.

    As in ``score``'s "forgets X most", a loss counts where its 95 % interval over runs leaves out 0; one run
    has none, and counts.
    """
    if (trial.metric("learning_performance").mean or 0.0) < LEAST_LEARNED or not trial.stage_matrices:
        return None
    cells = heat.mean(trial.stage_matrices)
    losses = []
    for index, task in enumerate(trial.tasks[:-1]):
        low = interval([run[index + 1][index] - run[-1][index] for run in trial.stage_matrices]).low
        before, after = cells[index + 1][index], cells[-1][index]
        reference = _reference(trial, task)
        shares = [reference.normalize(value) for value in (before, after)] if reference else []
        known = [share for share in shares if share is not None]
        if len(known) == 2 and (low is None or low > 0):
            losses.append((known[0] - known[1], -index, Lost(task, before, after)))
    worst = max(losses, default=None, key=lambda loss: loss[:2])
    return worst[2] if worst and worst[0] >= LITTLE_LOST else None


def curves(trial: Trial) -> list[Panel]:
    """For each task that has one, its training curves, raw, on one scale for the group."""
    group_curves = trial.detail.curves if trial.detail else ()
    points = [point for curve in group_curves for point in curve.points]
    if not points:
        return []
    y = around((value for _, value in points), *Y, always=())
    last = max(step for step, _ in points)
    x = Axis(0, last or 1.0, *X)
    levels = (min(value for _, value in points), max(value for _, value in points))
    made = []
    for task in trial.tasks:
        lines = [curve.points for curve in group_curves if curve.task == task]
        if lines:
            ended = ", ".join(fixed(line[-1][1], 0) for line in lines if line)
            label = f"{task}: training returns, at the end {ended}"
            drawing = charts.panel(lines, x, y, label, levels=levels)
            made.append(Panel(words.variation(task, trial.tasks), f"{grouped(int(last))} steps", drawing))
    return made
