"""The rules of a pull request with data, one function each, whose docstring is the published text."""

from __future__ import annotations

from gym_extensions.curation.gate.changes import PullRequest
from gym_extensions.curation.gate.rules import files, names, scope  # registers the rules
from gym_extensions.curation.gate.rules.rule import RULES
from gym_extensions.rollouts.problem import Problem

__all__ = ["RULES", "broken_rules", "files", "names", "scope"]


def broken_rules(pull_request: PullRequest) -> list[Problem]:
    """The problems of a pull request that changes data."""
    return [
        Problem(name, finding.where, finding.message, finding.hint)
        for name, function in RULES.items()
        for finding in function(pull_request)
    ]
