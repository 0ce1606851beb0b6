"""Suites: groups that are scored together; only an entry with every group of a suite has a score on it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from gym_extensions.catalog.suites import SUITES
from gym_extensions.scoring.metrics.definitions import METRICS, Metric
from gym_extensions.scoring.metrics.evaluate import ONE_RUN, Score
from gym_extensions.scoring.scorecard.estimates import estimate
from gym_extensions.scoring.statistics.intervals import to_interval


def _score(groups: Mapping[str, Any], suite: str, protocol: str, metric: Metric) -> Score:
    whole = estimate(groups, SUITES[suite], protocol, metric)
    if whole is None:
        lacking = [name for name in SUITES[suite] if estimate(groups, (name,), protocol, metric) is None]
        return Score(None, why=f"It has no value in {', '.join(lacking)}.")
    found = to_interval(whole)
    return Score(found, why=ONE_RUN if found.low is None else "")


def suite_scores(groups: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Every suite that an entry has whole, by protocol: the mean of each metric over the suite's groups.

    Args:
        groups: the ``groups`` of a scorecard.
    """
    found: dict[str, dict[str, Any]] = {}
    for suite, names in SUITES.items():
        for protocol, metrics in METRICS.items():
            if all(protocol in groups.get(name, {}) for name in names):
                found.setdefault(suite, {})[protocol] = {
                    "budget": groups[names[0]][protocol]["budget"],
                    "groups": list(names),
                    "metrics": {one.name: _score(groups, suite, protocol, one).as_dict() for one in metrics},
                }
    return found
