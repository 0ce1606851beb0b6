"""The value of every metric of an entry: over the runs of a group, and over the groups of a suite."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Collection, Iterable, Mapping, Sequence

from gym_extensions.catalog.groups import SUITES
from gym_extensions.references import Reference, References
from gym_extensions.scoring.entry.normalization import GroupReturns, normalized_runs
from gym_extensions.scoring.formulas import FINAL, JOINT_GAP, METRICS, Metric, MetricValue, Run
from gym_extensions.scoring.scorecard import GroupScore, SuiteScore
from gym_extensions.scoring.statistics import Summary, mean_of_groups, subtract, summary, to_interval

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
Groups = Mapping[str, Mapping[str, GroupScore]]
"""Scores by group id and protocol, as in a scorecard."""


def over_runs(metric: Metric, runs: Sequence[Run], tasks: Sequence[Reference] = ()) -> MetricValue:
    """The value of a metric that is a function of one run, over runs, or why there is none.

    Without the references of the group's tasks the interval has no errors of experts.
    """
    values: list[float] = []
    for run in runs:
        try:
            value = metric.of_run(run)
        except KeyError:
            if "curves" not in metric.needs:
                raise
            return MetricValue(why=TOO_FEW_POINTS)
        if value is None:
            return MetricValue(why=NO_TERM if run.scored else ALL_OPEN)
        values.append(value)
    anchors = anchor_errors(metric, runs, tasks)
    return MetricValue.of(to_interval(summary(values), anchor_terms(anchors, tasks)), values, anchors)


def anchor_errors(metric: Metric, runs: Sequence[Run], tasks: Sequence[Reference]) -> list[float]:
    """What the error of each task's expert adds to the standard error of a metric's mean over runs.

    By the delta method it is the task's share of the mean times the expert's standard error in spans: of
    final performance, mean(p[T][j]) / T · standard error / (expert − floor). It has the share's sign. Empty
    if no expert has an error.
    """
    if not any(task.relative_error for task in tasks):
        return []
    shares = [metric.shares(run) for run in runs]
    means = [math.fsum(share.get(j, 0.0) for share in shares) / len(shares) for j in range(1, len(tasks) + 1)]
    return [share * task.relative_error for share, task in zip(means, tasks, strict=True)]


def anchor_terms(errors: Iterable[float], tasks: Iterable[Reference]) -> list[tuple[float, float]]:
    """The squared errors of :func:`anchor_errors` with their degrees of freedom."""
    return [(error * error, task.df) for error, task in zip(errors, tasks, strict=False)]


def joint_gap(final: MetricValue, joint: MetricValue, tasks: Sequence[Reference] = ()) -> MetricValue:
    """Joint minus sequential final performance. Runs are not paired, so the interval is Welch's."""
    if not final.runs or not joint.runs:
        return MetricValue(why=final.why or joint.why)
    anchors = [b - a for a, b in zip(final.anchors, joint.anchors, strict=True)]
    gap = to_interval(subtract(summary(joint.runs), summary(final.runs)), anchor_terms(anchors, tasks))
    return MetricValue.of(gap, anchors=anchors)


def metric_values(
    results: GroupReturns, references: References, protocol: str, runs: Sequence[Run]
) -> dict[str, MetricValue]:
    """The value of every metric of a protocol by its name, in the order of the metrics' table.

    A metric that compares runs of two protocols is over the training seeds that have both.
    ``runs`` are the protocol's normalized runs, empty where a task of the group has no reference.
    """
    ids = results.group.task_ids
    if missing := references.missing(ids):
        why = f"{len(missing)} of {len(ids)} tasks have no floor and expert in version {references.version} "
        value = MetricValue(why=f"{why}of the references, {missing[0]} among them.")
        return {metric.name: value for metric in METRICS[protocol]}
    tasks = [references.tasks[task] for task in ids]
    present = {*results.runs, *(["curves"] if results.curves else [])}
    values: dict[str, MetricValue] = {}
    for metric in METRICS[protocol]:
        if lacking := [NEEDS[name] for name in metric.needs if name not in present]:
            value = MetricValue(why=f"It needs {' and '.join(lacking)}, which this entry lacks.")
        elif metric is JOINT_GAP:
            joint = over_runs(FINAL, normalized_runs(results, references, "joint"), tasks)
            value = joint_gap(values[FINAL.name], joint, tasks)
        else:
            partners = [set(results.runs[name]) for name in metric.needs if name in results.runs]
            numbered = zip(results.runs[protocol], runs, strict=True)
            paired = [run for number, run in numbered if all(number in each for each in partners)]
            value = over_runs(metric, paired, tasks)
        values[metric.name] = value
    return values


def estimate(groups: Groups, names: Iterable[str], protocol: str, metric: Metric) -> Summary | None:
    """The mean over independent groups of a metric's mean over runs; None without a value in one of them."""
    parts = [_of_group(groups.get(name, {}), protocol, metric) for name in names]
    present = [part for part in parts if part is not None]
    if not present or len(present) < len(parts):
        return None
    return present[0] if len(present) == 1 else mean_of_groups(present)


def _of_group(protocols: Mapping[str, GroupScore], protocol: str, metric: Metric) -> Summary | None:
    if metric is JOINT_GAP:  # not a function of one run: joint and sequential runs are not paired
        joint, sequential = (_of_group(protocols, name, FINAL) for name in ("joint", protocol))
        return subtract(joint, sequential) if joint and sequential else None
    score = protocols.get(protocol)
    value = score.metrics.get(metric.name) if score else None
    return summary(value.runs) if value and value.runs else None


def suite_scores(groups: Groups) -> dict[str, dict[str, SuiteScore]]:
    """The mean of each metric over a suite's groups, by suite and protocol, of suites with every group."""
    suites: dict[str, dict[str, SuiteScore]] = {}
    for suite, names in SUITES.items():
        for protocol, metrics in METRICS.items():
            if all(protocol in groups.get(name, {}) for name in names):
                values = {metric.name: _suite_value(groups, names, protocol, metric) for metric in metrics}
                score = SuiteScore(groups[names[0]][protocol].budget, tuple(names), values)
                suites.setdefault(suite, {})[protocol] = score
    return suites


def _suite_value(groups: Groups, names: Sequence[str], protocol: str, metric: Metric) -> MetricValue:
    total = estimate(groups, names, protocol, metric)
    if total is None:
        missing = [name for name in names if estimate(groups, (name,), protocol, metric) is None]
        return MetricValue(why=f"It has no value in {', '.join(missing)}.")
    anchors = suite_anchors([groups[name][protocol] for name in names], metric)
    return MetricValue.of(to_interval(total, anchors))


def suite_anchors(scores: Collection[GroupScore], metric: Metric) -> list[tuple[float, float]]:
    """The squared errors of the experts of all tasks in the mean over these groups, and their df."""
    errors, df = defaultdict[str, float](float), {}
    for score in scores:
        for task, error in zip(score.tasks, score.metrics[metric.name].anchors, strict=False):
            errors[task] += error / len(scores)
            df[task] = score.reference[task].df or 0.0
    return [(error * error, df[task]) for task, error in errors.items()]
