"""Two entries side by side: for every metric that both have, the interval of their difference."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from gym_extensions.catalog.suites import SUITES
from gym_extensions.errors import BenchError
from gym_extensions.scoring.metrics.definitions import METRICS
from gym_extensions.scoring.scorecard.estimates import estimate
from gym_extensions.scoring.statistics.intervals import subtract, to_interval

Document = dict[str, Any]


def _metrics(first: Document, second: Document, names: Sequence[str], protocol: str) -> Document:
    found = {}
    for metric in METRICS[protocol]:
        one, other = (estimate(card["groups"], names, protocol, metric) for card in (first, second))
        if one is not None and other is not None:
            gap = to_interval(subtract(one, other))
            found[metric.name] = {
                "first": one.mean,
                "second": other.mean,
                "difference": {"mean": gap.mean, "low": gap.low, "high": gap.high},
            }
    return found


def _common(first: Document, second: Document, part: str) -> Document:
    """What both have of the groups or of the suites, by name and protocol, with the same budget."""
    found: Document = {}
    for name, protocols in first[part].items():
        for protocol, scored in protocols.items():
            other = second[part].get(name, {}).get(protocol)
            if other is not None and other["budget"] == scored["budget"]:
                metrics = _metrics(first, second, SUITES.get(name, (name,)), protocol)
                found.setdefault(name, {})[protocol] = {"budget": scored["budget"], "metrics": metrics}
    return found


def compare(first: Document, second: Document) -> Document:
    """The comparison of two scorecards, as docs/scorecard.md describes it.

    Intervals are Welch's for this one pair, 95 %, not corrected for other pairs that one might also look at.

    Raises:
        BenchError: a submission has problems, or the two have no group with the same protocol and budget.
    """
    for card in (first, second):
        if card["problems"]:
            hint = f"Run: score {card['name']}."
            raise BenchError("not-scored", "The submission has problems.", card["name"], hint)
    groups = _common(first, second, "groups")
    if not groups:
        message = f"{first['name']} and {second['name']} have no group with the same protocol and budget."
        raise BenchError("nothing-to-compare", message, hint="Compare entries of one board.")
    return {"format": 1, "first": first["name"], "second": second["name"], "groups": groups} | {
        "suites": _common(first, second, "suites")
    }
