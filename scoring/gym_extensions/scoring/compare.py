"""Two entries side by side: for every metric that both have, the interval of their difference."""

from __future__ import annotations

from typing import Any

from gym_extensions.catalog.errors import BenchError
from gym_extensions.scoring.intervals import difference
from gym_extensions.scoring.metrics import METRICS

Document = dict[str, Any]


def _metrics(first: Document, second: Document, protocol: str) -> Document:
    found = {}
    for metric in METRICS[protocol]:
        pair = [one["metrics"][metric.name]["runs"] for one in (first, second)]
        if all(pair):
            gap = difference(*pair)
            found[metric.name] = {
                "first": first["metrics"][metric.name]["mean"],
                "second": second["metrics"][metric.name]["mean"],
                "difference": {"mean": gap.mean, "low": gap.low, "high": gap.high},
            }
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
    groups: Document = {}
    for name, protocols in first["groups"].items():
        for protocol, scored in protocols.items():
            other = second["groups"].get(name, {}).get(protocol)
            if other is not None and other["budget"] == scored["budget"]:
                metrics = _metrics(scored, other, protocol)
                groups.setdefault(name, {})[protocol] = {"budget": scored["budget"], "metrics": metrics}
    if not groups:
        message = f"{first['name']} and {second['name']} have no group with the same protocol and budget."
        raise BenchError("nothing-to-compare", message, hint="Compare entries of one board.")
    return {"format": 1, "first": first["name"], "second": second["name"], "groups": groups}
