"""Means over the groups of a suite."""

from collections import defaultdict
from collections.abc import Collection, Iterable, Mapping, Sequence

from gym_extensions.catalog.groups import SUITES
from gym_extensions.metrics.formulas import FINAL, JOINT_GAP, METRICS, Metric
from gym_extensions.metrics.statistics import Summary, mean_of_groups, subtract, summary, to_interval
from gym_extensions.metrics.values import MetricValue
from gym_extensions.scoring.group_score import GroupScore, SuiteScore

Scores = dict[str, dict[str, GroupScore]]
"""Scores by group id and protocol, as in a scorecard."""


def estimate(groups: Scores, names: Iterable[str], protocol: str, metric: Metric) -> Summary | None:
    """The mean over independent groups of a metric's mean over runs; None without a value in one of them."""
    parts = [_of_group(groups.get(name, {}), protocol, metric) for name in names]
    present = [part for part in parts if part is not None]
    if not present or len(present) < len(parts):
        return None
    return present[0] if len(present) == 1 else mean_of_groups(present)


def _of_group(protocols: Mapping[str, GroupScore], protocol: str, metric: Metric) -> Summary | None:
    if metric is JOINT_GAP:  # not a function of one run: joint and sequential runs are not paired
        if len({protocols[name].budget for name in ("joint", protocol) if name in protocols}) > 1:
            return None
        joint, sequential = (_of_group(protocols, name, FINAL) for name in ("joint", protocol))
        return subtract(joint, sequential) if joint and sequential else None
    score = protocols.get(protocol)
    value = score.metrics.get(metric.name) if score else None
    return summary(value.runs) if value and value.runs else None


def suite_scores(groups: Scores) -> dict[str, dict[str, SuiteScore]]:
    """The mean of each metric over a suite's groups, by suite and protocol.

    Of suites with every group, all with the same budget.
    """

    def value(names: Sequence[str], protocol: str, metric: Metric) -> MetricValue:
        total = estimate(groups, names, protocol, metric)
        if total is None:
            missing = [name for name in names if estimate(groups, (name,), protocol, metric) is None]
            return MetricValue(why=f"It has no value in {', '.join(missing)}.")
        errors = suite_expert_errors([groups[name][protocol] for name in names], metric)
        return MetricValue.of(to_interval(total, errors))

    suites: dict[str, dict[str, SuiteScore]] = {}
    for suite, names in SUITES.items():
        for protocol, metrics in METRICS.items():
            logs = [log for name in names if (log := groups.get(name, {}).get(protocol))]
            budgets = {log.budget for log in logs}
            if len(logs) == len(names) and len(budgets) == 1:
                values = {metric.name: value(names, protocol, metric) for metric in metrics}
                score = SuiteScore(budgets.pop(), tuple(names), values)
                suites.setdefault(suite, {})[protocol] = score
    return suites


def suite_expert_errors(scores: Collection[GroupScore], metric: Metric) -> list[tuple[float, float]]:
    """The squared errors of the experts of all tasks in the mean over these groups, and their df."""
    errors, df = defaultdict[str, float](float), {}
    for score in scores:
        for task, error in zip(score.tasks, score.metrics[metric.name].expert_errors, strict=False):
            errors[task] += error / len(scores)
            df[task] = score.reference[task].df or 0.0
    return [(error * error, df[task]) for task, error in errors.items()]
