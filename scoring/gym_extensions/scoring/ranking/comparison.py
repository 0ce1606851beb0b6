"""The comparison of two entries, group by group, outside of any board."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from gym_extensions.catalog.groups import SUITES
from gym_extensions.errors import BenchError
from gym_extensions.scoring.entry.values import estimate
from gym_extensions.scoring.formulas import METRICS
from gym_extensions.scoring.ranking.boards import (
    ComparedMetric,
    ComparedScore,
    ComparedScores,
    Comparison,
    Difference,
)
from gym_extensions.scoring.scorecard import GroupScore, Scorecard, SuiteScore

Scores = Mapping[str, Mapping[str, GroupScore]] | Mapping[str, Mapping[str, SuiteScore]]


def compare(first: Scorecard, second: Scorecard) -> Comparison:
    """The comparison of two scorecards, with Welch's 95 % intervals for this one pair.

    Raises:
        BenchError: a submission has problems, or the two have no group with the same protocol and budget.
    """
    for card in (first, second):
        if card.problems:
            hint = f"Run: score {card.name}."
            raise BenchError("not-scored", "The submission has problems.", card.name, hint)

    def metrics(names: Sequence[str], protocol: str) -> dict[str, ComparedMetric]:
        found = {}
        for metric in METRICS[protocol]:
            a, b = (estimate(card.groups, names, protocol, metric) for card in (first, second))
            if a is not None and b is not None:
                found[metric.name] = ComparedMetric(a.mean, b.mean, Difference.of(a, b))
        return found

    def common(scores: Scores, others: Scores) -> ComparedScores:
        """What both entries have, by group or suite and protocol, with the same budget."""
        both: ComparedScores = {}
        for name, protocols in scores.items():
            for protocol, score in protocols.items():
                other = others.get(name, {}).get(protocol)
                if other is not None and other.budget == score.budget:
                    values = metrics(SUITES.get(name, (name,)), protocol)
                    both.setdefault(name, {})[protocol] = ComparedScore(score.budget, values)
        return both

    groups = common(first.groups, second.groups)
    if not groups:
        message = f"{first.name} and {second.name} have no group with the same protocol and budget."
        raise BenchError("nothing-to-compare", message, hint="Compare entries of one board.")
    suites = common(first.suites, second.suites)
    return Comparison(first=first.name, second=second.name, groups=groups, suites=suites)
