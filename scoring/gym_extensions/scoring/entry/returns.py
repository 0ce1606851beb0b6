"""Checked logs -> raw returns -> normalized runs -> the value of every metric."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.catalog.protocol import BUDGETS, EVALUATION_EPISODES, stages
from gym_extensions.rollouts.submission import SubmittedGroup
from gym_extensions.scoring.metrics import FINAL, METRICS, Metric, MetricValue, Run, area
from gym_extensions.scoring.references import Reference, References
from gym_extensions.scoring.statistics import subtract, summary, with_anchors

Cells = list[list[list[list[float]]]]
Means = list[list[list[float]]]
Rates = tuple[tuple[tuple[float | None, ...], ...], ...]
Curve = tuple[list[int], list[float]]
"""A training curve: steps, and the mean return of the training episodes that ended since the point before."""


@dataclass(frozen=True)
class Results:
    """Raw returns of a group.

    Attributes:
        group: the group.
        steps: the budget's training steps per task.
        runs: training seeds by protocol.
        returns: by protocol, [run][stage][task][episode]. All but sequential logs have one stage.
        curves: training curves by (protocol, run, task id).
        successes: as ``returns``: 1, 0, or -1 where the task defines no success.
    """

    group: TaskGroup
    steps: int
    runs: dict[str, tuple[int, ...]]
    returns: dict[str, Cells]
    curves: dict[tuple[str, int, str], Curve] = field(default_factory=dict)
    successes: dict[str, list[list[list[list[int]]]]] = field(default_factory=dict)

    @cached_property
    def means(self) -> dict[str, Means]:
        """Mean raw returns [run][stage][task] by protocol, by ``math.fsum``."""
        return {
            protocol: [[[math.fsum(cell) / len(cell) for cell in row] for row in run] for run in runs]
            for protocol, runs in self.returns.items()
        }

    def success_rates(self, protocol: str) -> Rates:
        """The share of episodes that succeeded, [run][stage][task].

        None where the task defines no success; empty if no task does.
        """
        rates = tuple(
            tuple(tuple(None if min(cell) < 0 else sum(cell) / len(cell) for cell in row) for row in run)
            for run in self.successes.get(protocol, ())
        )
        is_defined = any(rate is not None for run in rates for row in run for rate in row)
        return rates if is_defined else ()


def results(entry: SubmittedGroup, budget: str) -> Results:
    """The returns of a group's checked logs."""
    tasks = len(entry.group.tasks)
    shapes = {
        protocol: (len(log.runs), len(stages(protocol, tasks)), tasks, EVALUATION_EPISODES)
        for protocol, log in entry.logs.items()
    }
    return Results(
        group=entry.group,
        steps=BUDGETS[budget].steps_for(entry.group.name),
        runs={protocol: log.runs for protocol, log in entry.logs.items()},
        returns={name: log.return_.reshape(shapes[name]).tolist() for name, log in entry.logs.items()},
        curves={
            (protocol, run, curve.task): (curve.steps, curve.returns)
            for protocol, documents in entry.runs.items()
            for run, document in documents.items()
            for curve in document.curves
        },
        successes={name: log.success.reshape(shapes[name]).tolist() for name, log in entry.logs.items()},
    )


def normalized_runs(results: Results, references: References, protocol: str) -> list[Run]:
    """One Run per training seed of a protocol's log. Every task of the group needs a reference.

    ``single_task``, ``cumulative`` and the areas are filled in where the entry has such runs and curves.
    """
    ids = results.group.task_ids
    scored = {j: reference for j, task in enumerate(ids, 1) if not (reference := references.tasks[task]).open}
    T = len(ids)
    first_stage = 0 if protocol == "sequential" else T

    def last_stage(name: str, run: int, positions: Iterable[int]) -> dict[int, float]:
        """The scores of the run of this seed in another log, by position."""
        if run not in results.runs.get(name, ()):
            return {}
        (means,) = results.means[name][results.runs[name].index(run)]
        return {j: scored[j].normalize(means[j - 1]) for j in positions}

    def areas(name: str, run: int) -> dict[int, float]:
        """The areas under the training curves of the run of this seed, by position."""
        heights = {}
        for j, reference in scored.items():
            steps, values = results.curves.get((name, run, ids[j - 1]), ([], []))
            heights[j] = area(steps, reference.normalize_all(values), results.steps)
        return {j: height for j, height in heights.items() if height is not None}

    return [
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
            single_task=last_stage("single", run, scored),
            cumulative=last_stage("cumulative", run, scored.keys() & {T}),
            auc=areas("sequential", run) if protocol == "sequential" else {},
            single_task_auc=areas("single", run) if protocol == "sequential" else {},
        )
        for run, episodes, means in zip(
            results.runs[protocol], results.returns[protocol], results.means[protocol], strict=True
        )
    ]


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


def over_runs(metric: Metric, runs: Sequence[Run], tasks: Sequence[Reference] = ()) -> MetricValue:
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


def metric_values(
    results: Results, references: References, protocol: str, runs: Sequence[Run]
) -> dict[str, MetricValue]:
    """The value of every metric of a protocol by its name, in the order of the metrics' table.

    Args:
        results: the group's raw returns.
        references: floors and experts.
        protocol: ``sequential``, ``single``, ``joint`` or ``cumulative``.
        runs: the protocol's normalized runs; empty where a task of the group has no reference.
    """
    ids = results.group.task_ids
    unknown = ""
    if missing := references.missing(ids):
        unknown = (
            f"{len(missing)} of {len(ids)} tasks have no floor and expert in version {references.version} "
            f"of the references, {missing[0]} among them."
        )
    tasks = [] if missing else [references.tasks[task] for task in ids]
    values: dict[str, MetricValue] = {}
    for metric in METRICS[protocol]:
        lacking = missing_words(metric.needs, results)
        why = unknown or (f"It needs {' and '.join(lacking)}, which this entry lacks." if lacking else "")
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
