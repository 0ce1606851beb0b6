"""The registry of the rules."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from gym_extensions.curation.gate.changes import PullRequest
from gym_extensions.rollouts.problem import Finding

Rule = Callable[[PullRequest], Iterator[Finding]]

RULES: dict[str, Rule] = {}
"""Every rule by name, in the order of their definition."""


def rule(function: Rule) -> Rule:
    """Registers a rule; its name is the function's with dashes."""
    RULES[function.__name__.replace("_", "-")] = function
    return function
