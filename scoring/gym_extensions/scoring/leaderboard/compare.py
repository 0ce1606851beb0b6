"""Compares two entries by the interval of their difference, for every metric that both have."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from gym_extensions.catalog.suites import SUITES
from gym_extensions.errors import BenchError
from gym_extensions.scoring.leaderboard.model import (
    ComparedMetric,
    ComparedScore,
    ComparedScores,
    Comparison,
    Difference,
)
from gym_extensions.scoring.metrics.definitions import METRICS
from gym_extensions.scoring.scorecard.estimates import estimate
from gym_extensions.scoring.scorecard.model import GroupScore, Scorecard, SuiteScore
from gym_extensions.scoring.statistics.intervals import subtract, to_interval

Scores = Mapping[str, Mapping[str, GroupScore]] | Mapping[str, Mapping[str, SuiteScore]]


def _metrics(
    first: Scorecard, second: Scorecard, names: Sequence[str], protocol: str
) -> dict[str, ComparedMetric]:
    metrics = {}
    for metric in METRICS[protocol]:
        a, b = (estimate(card.groups, names, protocol, metric) for card in (first, second))
        if a is not None and b is not None:
            metrics[metric.name] = ComparedMetric(a.mean, b.mean, Difference.of(to_interval(subtract(a, b))))
    return metrics


def _common(first: Scorecard, second: Scorecard, scores: Scores, others: Scores) -> ComparedScores:
    """What both entries have, by group or suite and protocol, with the same budget."""
    common: ComparedScores = {}
    for name, protocols in scores.items():
        for protocol, score in protocols.items():
            other = others.get(name, {}).get(protocol)
            if other is not None and other.budget == score.budget:
                metrics = _metrics(first, second, SUITES.get(name, (name,)), protocol)
                common.setdefault(name, {})[protocol] = ComparedScore(score.budget, metrics)
    return common


def compare(first: Scorecard, second: Scorecard) -> Comparison:
    """The comparison of two scorecards.

    Intervals are Welch's for this one pair, 95 %, not corrected for multiple comparisons.

    Raises:
        BenchError: a submission has problems, or the two have no group with the same protocol and budget.
    """
    for card in (first, second):
        if card.problems:
            hint = f"Run: score {card.name}."
            raise BenchError("not-scored", "The submission has problems.", card.name, hint)
    groups = _common(first, second, first.groups, second.groups)
    if not groups:
        message = f"{first.name} and {second.name} have no group with the same protocol and budget."
        raise BenchError("nothing-to-compare", message, hint="Compare entries of one board.")
    suites = _common(first, second, first.suites, second.suites)
    return Comparison(first=first.name, second=second.name, groups=groups, suites=suites)
