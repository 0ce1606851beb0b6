"""Checked logs -> raw returns as arrays -> normalized runs -> the value of every metric."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.catalog.protocol import BUDGETS, EVALUATION_EPISODES, stages
from gym_extensions.rollouts.submission import SubmittedGroup
from gym_extensions.rollouts.tables import Log
from gym_extensions.scoring.metrics import (
    FINAL,
    METRICS,
    Metric,
    MetricValue,
    Run,
    area,
)
from gym_extensions.scoring.references import Reference, References
from gym_extensions.scoring.statistics import subtract, summary, with_anchors

Returns = NDArray[np.float64]
Cells = list[list[list[list[float]]]]
Means = list[list[list[float]]]
Rates = tuple[tuple[tuple[float | None, ...], ...], ...]
Successes = NDArray[np.int8]
Curve = tuple[list[int], list[float]]
"""A training curve: steps, and the mean return of the training episodes that ended since the point before."""


@dataclass(frozen=True)
class Results:
    """Raw returns of a group.

    Attributes:
        group: the group.
        steps: the budget's training steps per task.
        runs: training seeds by protocol.
        sequential: returns [run, stage, task, episode], or None without the log.
        single: returns [run, task, episode], or None without the log.
        joint: returns [run, task, episode], or None without the log.
        cumulative: returns [run, task, episode], or None without the log.
        curves: training curves by (protocol, run, task id).
        successes: [run, stage, task, episode] by protocol: 1, 0, or -1 where the task defines no success.
    """

    group: TaskGroup
    steps: int
    runs: dict[str, tuple[int, ...]]
    sequential: Returns | None = None
    single: Returns | None = None
    joint: Returns | None = None
    cumulative: Returns | None = None
    curves: dict[tuple[str, int, str], Curve] = field(default_factory=dict)
    successes: dict[str, Successes] = field(default_factory=dict)

    @functools.cached_property
    def returns(self) -> dict[str, Cells]:
        """Returns [run][stage][task][episode] by protocol. All but sequential logs have one stage."""
        arrays = {
            "sequential": self.sequential,
            "single": None if self.single is None else self.single[:, None],
            "joint": None if self.joint is None else self.joint[:, None],
            "cumulative": None if self.cumulative is None else self.cumulative[:, None],
        }
        return {protocol: array.tolist() for protocol, array in arrays.items() if array is not None}

    @functools.cached_property
    def means(self) -> dict[str, Means]:
        """Mean raw returns [run][stage][task] by protocol, by ``math.fsum``."""
        return {
            protocol: [[[math.fsum(cell) / len(cell) for cell in row] for row in run] for run in runs]
            for protocol, runs in self.returns.items()
        }


def _shape(log: Log) -> tuple[int, int, int, int]:
    """Runs, stages, tasks and episodes of a log."""
    tasks = len(log.group.tasks)
    return len(log.runs), len(stages(log.protocol, tasks)), tasks, EVALUATION_EPISODES


def _array(log: Log | None) -> Returns | None:
    if log is None:
        return None
    shape = _shape(log)
    if log.return_.size != np.prod(shape):
        raise ValueError(f"{log.path} is not a complete log.")
    cells = log.return_.reshape(shape)
    return cells if log.protocol == "sequential" else cells[:, 0]


def success_rates(successes: Successes) -> Rates:
    """The share of episodes that succeeded, [run][stage][task].

    None where the task defines no success; empty if no task does.

    Args:
        successes: [run, stage, task, episode]; 1, 0, or -1 where the task defines none.
    """
    if (successes < 0).all():
        return ()
    return tuple(
        tuple(tuple(None if min(cell) < 0 else sum(cell) / len(cell) for cell in row) for row in run)
        for run in successes.tolist()
    )


def results(entry: SubmittedGroup, budget: str) -> Results:
    """The returns of a group's checked logs."""
    return Results(
        group=entry.group,
        steps=BUDGETS[budget].steps_for(entry.group.name),
        runs={protocol: log.runs for protocol, log in entry.logs.items()},
        sequential=_array(entry.logs.get("sequential")),
        single=_array(entry.logs.get("single")),
        joint=_array(entry.logs.get("joint")),
        cumulative=_array(entry.logs.get("cumulative")),
        curves={
            (protocol, run, curve.task): (curve.steps, curve.returns)
            for protocol, documents in entry.runs.items()
            for run, document in documents.items()
            for curve in document.curves
        },
        successes={protocol: log.success.reshape(_shape(log)) for protocol, log in entry.logs.items()},
    )


def _areas(results: Results, protocol: str, run: int, scored: dict[int, Reference]) -> dict[int, float]:
    areas = {}
    for j, reference in scored.items():
        steps, values = results.curves.get((protocol, run, results.group.task_ids[j - 1]), ([], []))
        height = area(steps, reference.normalize_all(values), results.steps)
        if height is not None:
            areas[j] = height
    return areas


def normalized_runs(results: Results, references: References, protocol: str) -> list[Run]:
    """One Run per training seed of a protocol's log.

    Every task of the group needs a reference.

    ``single_task`` and the areas are filled in where the log has a single log or curves beside it.
    """
    ids = results.group.task_ids
    scored = {j: reference for j, task in enumerate(ids, 1) if not (reference := references.tasks[task]).open}
    T = len(ids)
    single = dict(zip(results.runs.get("single", ()), results.means.get("single", ()), strict=True))
    cumulative = dict(
        zip(results.runs.get("cumulative", ()), results.means.get("cumulative", ()), strict=True)
    )
    first_stage = 0 if protocol == "sequential" else T
    runs = []
    for seed, episodes, means in zip(
        results.runs[protocol], results.returns[protocol], results.means[protocol], strict=True
    ):
        with_curves = scored if protocol == "sequential" else {}
        runs.append(
            Run(
                T=T,
                scored=tuple(scored),
                normalized_returns={
                    (s, j): reference.normalize(row[j - 1])
                    for s, row in enumerate(means, first_stage)
                    for j, reference in scored.items()
                },
                final_episodes={
                    j: tuple(reference.normalize_all(episodes[-1][j - 1])) for j, reference in scored.items()
                },
                single_task={
                    j: reference.normalize(single[seed][0][j - 1])
                    for j, reference in (scored if seed in single else {}).items()
                },
                cumulative={
                    j: reference.normalize(cumulative[seed][0][j - 1])
                    for j, reference in (scored if seed in cumulative else {}).items()
                    if j == T
                },
                auc=_areas(results, protocol, seed, with_curves),
                single_task_auc=_areas(results, "single", seed, with_curves),
            )
        )
    return runs


ONE_RUN = "One run has no interval."
ALL_OPEN = "Every task of this group is open: no expert is known that is clearly better than the floor."
NO_TERM = "No task with an expert meets the formula's condition on j."
TOO_FEW_POINTS = "A training curve that it needs is missing or has fewer than 10 points."
NEEDS = {
    "sequential": "sequential runs",
    "single": "single-task runs",
    "joint": "joint runs",
    "cumulative": "cumulative runs",
    "curves": "training curves",
}
"""What metrics need besides their own log, in words."""


def missing_words(needs: Iterable[str], results: Results) -> list[str]:
    """What an entry lacks of these (protocols, and ``curves``), in words."""
    present = {*results.runs, *(["curves"] if results.curves else [])}
    return [NEEDS[name] for name in needs if name not in present]


def over_runs(metric: Metric, runs: list[Run], tasks: Sequence[Reference] = ()) -> MetricValue:
    """The value of a metric over runs, or why there is none.

    Args:
        metric: a metric that is a function of one run.
        runs: the normalized runs.
        tasks: the references of the group's tasks; without them the interval is that over the runs.
    """
    values: list[float] = []
    for run in runs:
        try:
            value = metric.function(run) if metric.function else None
        except KeyError:
            return MetricValue(why=TOO_FEW_POINTS)
        if value is None:
            return MetricValue(why=NO_TERM if run.scored else ALL_OPEN)
        values.append(value)
    anchors = anchor_errors(metric, runs, tasks)
    whole = with_anchors(summary(values), anchor_terms(anchors, tasks))
    return MetricValue.of(whole, tuple(values), ONE_RUN if len(values) == 1 else "", anchors)


def anchor_errors(metric: Metric, runs: Sequence[Run], tasks: Sequence[Reference]) -> tuple[float, ...]:
    """What the error of each task's expert adds to the standard error of a metric's mean over runs.

    By the delta method it is the task's share of the mean times the expert's standard error in spans: of
    final performance, mean(p[T][j]) / T · standard error / (expert − floor). It has the share's sign.

    Returns:
        One number per task; empty if no expert has an error.
    """
    if not any(task.relative_error for task in tasks):
        return ()
    shares = [metric.shares(run) for run in runs]
    means = [math.fsum(share.get(j, 0.0) for share in shares) / len(shares) for j in range(1, len(tasks) + 1)]
    return tuple(share * task.relative_error for share, task in zip(means, tasks, strict=True))


def anchor_terms(errors: Sequence[float], tasks: Sequence[Reference]) -> list[tuple[float, float]]:
    """The squared errors of :func:`anchor_errors` with their degrees of freedom."""
    return [(error * error, task.df) for error, task in zip(errors, tasks, strict=False)]


def joint_gap(final: MetricValue, joint: MetricValue, tasks: Sequence[Reference] = ()) -> MetricValue:
    """Joint minus sequential final performance. Runs are not paired, so the interval is Welch's."""
    if not final.runs or not joint.runs:
        return MetricValue(why=final.why or joint.why)
    anchors = tuple(b - a for a, b in zip(final.anchors, joint.anchors, strict=True))
    gap = with_anchors(subtract(summary(joint.runs), summary(final.runs)), anchor_terms(anchors, tasks))
    return MetricValue.of(gap, (), ONE_RUN if gap.low is None else "", anchors)


def no_reference(task_ids: Sequence[str], references: References) -> str:
    """The reason why a group cannot be normalized, which is a task without a reference.

    Empty where all have one.
    """
    missing = references.missing(task_ids)
    if not missing:
        return ""
    share = f"{len(missing)} of {len(task_ids)} tasks"
    return (
        f"{share} have no floor and expert in version {references.version} of the references, "
        f"{missing[0]} among them."
    )


def metric_values(
    results: Results, references: References, protocol: str, runs: list[Run]
) -> dict[str, MetricValue]:
    """The value of every metric of a protocol by its name, in the order of the metrics' table.

    Args:
        results: the group's raw returns.
        references: floors and experts.
        protocol: ``sequential``, ``single``, ``joint`` or ``cumulative``.
        runs: the protocol's normalized runs; empty where a task of the group has no reference.
    """
    unknown = no_reference(results.group.task_ids, references)
    tasks = [] if unknown else [references.tasks[task] for task in results.group.task_ids]
    values: dict[str, MetricValue] = {}
    for metric in METRICS[protocol]:
        missing = missing_words(metric.needs, results)
        why = unknown or (f"It needs {' and '.join(missing)}, which this entry lacks." if missing else "")
        if why:
            values[metric.name] = MetricValue(why=why)
        elif metric.function is None:
            joint = over_runs(FINAL, normalized_runs(results, references, "joint"), tasks)
            values[metric.name] = joint_gap(values[FINAL.name], joint, tasks)
        elif "cumulative" in metric.needs:  # made for some runs of the sequence only
            paired = over_runs(metric, [run for run in runs if run.cumulative], tasks)
            values[metric.name] = replace(paired, runs=())
        else:
            values[metric.name] = over_runs(metric, runs, tasks)
    return values
