"""Scores suites, the groups that are scored together.

An entry needs every group of a suite to have a score on it.
"""

from __future__ import annotations

from gym_extensions.catalog.suites import SUITES
from gym_extensions.scoring.metrics.definitions import METRICS
from gym_extensions.scoring.metrics.evaluate import ONE_RUN
from gym_extensions.scoring.metrics.metric import Metric
from gym_extensions.scoring.metrics.value import MetricValue
from gym_extensions.scoring.scorecard.estimates import Groups, estimate
from gym_extensions.scoring.scorecard.model import SuiteScore
from gym_extensions.scoring.statistics.intervals import to_interval


def _value(groups: Groups, suite: str, protocol: str, metric: Metric) -> MetricValue:
    total = estimate(groups, SUITES[suite], protocol, metric)
    if total is None:
        missing = [name for name in SUITES[suite] if estimate(groups, (name,), protocol, metric) is None]
        return MetricValue(why=f"It has no value in {', '.join(missing)}.")
    interval = to_interval(total)
    return MetricValue.of(interval, why=ONE_RUN if interval.low is None else "")


def suite_scores(groups: Groups) -> dict[str, dict[str, SuiteScore]]:
    """The mean of each metric over a suite's groups, by suite and protocol.

    Args:
        groups: scores by group id and protocol; suites with a missing group are left out.
    """
    suites: dict[str, dict[str, SuiteScore]] = {}
    for suite, names in SUITES.items():
        for protocol, metrics in METRICS.items():
            if all(protocol in groups.get(name, {}) for name in names):
                values = {metric.name: _value(groups, suite, protocol, metric) for metric in metrics}
                score = SuiteScore(groups[names[0]][protocol].budget, tuple(names), values)
                suites.setdefault(suite, {})[protocol] = score
    return suites
