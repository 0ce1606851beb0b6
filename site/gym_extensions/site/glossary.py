"""The scorer's metrics as a reader meets them: title, formula, which way is better."""

from __future__ import annotations

from dataclasses import dataclass

from gym_extensions.scoring.metrics.definitions import METRICS


@dataclass(frozen=True)
class Term:
    """A metric in words."""

    name: str
    title: str
    formula: str
    better: str
    known_as: str = ""


TERMS: dict[str, Term] = {
    metric.name: Term(metric.name, metric.title, metric.formula, metric.better, metric.known_as)
    for protocol in METRICS.values()
    for metric in protocol
}
"""Every metric by its name, in the scorer's order."""

ARROWS = {"higher": "higher is better", "lower": "lower is better"}


def metric(name: str) -> Term:
    """The metric of that name; one that the scorer does not know is called by its name alone."""
    return TERMS.get(name) or Term(name, name.replace("_", " ").capitalize(), "", "")


def better(name: str) -> str:
    """Which way is better, in words, or that it is not ranked."""
    return ARROWS.get(metric(name).better, "not ranked")
