"""Every metric of one group and protocol, with its interval over runs or the reason why it has no value."""

from __future__ import annotations

from gym_extensions.scoring.metrics.definitions import FINAL, METRICS
from gym_extensions.scoring.metrics.metric import Metric
from gym_extensions.scoring.metrics.normalization import normalized_runs
from gym_extensions.scoring.metrics.returns import Results
from gym_extensions.scoring.metrics.run import Run
from gym_extensions.scoring.metrics.value import MetricValue
from gym_extensions.scoring.references import References
from gym_extensions.scoring.statistics.intervals import difference, interval

ONE_RUN = "One run has no interval."
ALL_UNSOLVED = "Every task of this group is unsolved: no reference agent has learned it."
NO_TERM = "No task with a ceiling meets the formula's condition on j."
TOO_FEW_POINTS = "A training curve that it needs is missing from curves.csv or has fewer than 10 points."


def _missing_files(metric: Metric, results: Results) -> str:
    present = {*results.runs, *(["curves"] if results.curves else [])}
    missing = [f"{name}.csv" for name in metric.needs if name not in present]
    return f"It needs {' and '.join(missing)}, which this entry lacks." if missing else ""


def _over_runs(metric: Metric, runs: list[Run]) -> MetricValue:
    values: list[float] = []
    for run in runs:
        try:
            value = metric.function(run) if metric.function else None
        except KeyError:
            return MetricValue(why=TOO_FEW_POINTS)
        if value is None:
            return MetricValue(why=NO_TERM if run.scored else ALL_UNSOLVED)
        values.append(value)
    return MetricValue.of(interval(values), tuple(values), ONE_RUN if len(values) == 1 else "")


def _joint_gap(final: MetricValue, joint: MetricValue) -> MetricValue:
    """Joint minus sequential final performance. Runs are not paired, so the interval is Welch's."""
    if not final.runs or not joint.runs:
        return MetricValue(why=final.why or joint.why)
    gap = difference(joint.runs, final.runs)
    return MetricValue.of(gap, why=ONE_RUN if gap.low is None else "")


def no_reference(results: Results, references: References) -> str:
    """The reason why a group cannot be normalized, which is a task without a reference.

    Empty where all have one.
    """
    missing = references.missing(results.group.task_ids)
    if not missing:
        return ""
    share = f"{len(missing)} of {len(results.group.tasks)} tasks"
    return (
        f"No reference agent was trained on {share} (references version {references.version}), "
        f"{missing[0]} among them."
    )


def metric_values(
    results: Results, references: References, protocol: str, runs: list[Run]
) -> dict[str, MetricValue]:
    """The value of every metric of a protocol by its name, in the order of the metrics' table.

    Args:
        results: the group's raw returns.
        references: floors and ceilings.
        protocol: ``sequential``, ``single`` or ``joint``.
        runs: the protocol's normalized runs; empty where a task of the group has no reference.
    """
    unknown = no_reference(results, references)
    values: dict[str, MetricValue] = {}
    for metric in METRICS[protocol]:
        why = unknown or _missing_files(metric, results)
        if why:
            values[metric.name] = MetricValue(why=why)
        elif metric.function is None:
            joint = _over_runs(FINAL, normalized_runs(results, references, "joint"))
            values[metric.name] = _joint_gap(values[FINAL.name], joint)
        else:
            values[metric.name] = _over_runs(metric, runs)
    return values
