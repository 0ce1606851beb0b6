"""A rule is a function registered under its own name. Its docstring is the rule's text."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Literal

from gym_extensions.rollouts.problem import Finding, Problem

Scope = Literal[
    "folder",
    "unreadable",
    "manifest bytes",
    "manifest",
    "manifest in folder",
    "readme",
    "size",
    "text",
    "cells",
    "keys",
    "runs",
    "log",
    "group",
    "curves",
    "evaluations",
    "arrays",
    "policy",
    "policies",
    "salt",
    "traces",
]
"""What a rule checks. Each scope has one type of subject, the parameter of its rules."""
Check = Callable[[Any], Iterator[Finding]]


@dataclass(frozen=True)
class Rule:
    """A rule, with its name in kebab case, its scope, its text and its function."""

    name: str
    scope: Scope
    text: str
    check: Check


RULES: dict[str, Rule] = {}
"""Every rule by name, in the order in which they are checked within a scope."""


def rule(scope: Scope) -> Callable[[Check], Check]:
    """Registers a function as a rule with the function's name. Its docstring is the rule's text."""

    def register(check: Check) -> Check:
        name = check.__name__.replace("_", "-")
        if name in RULES or not check.__doc__:
            raise ValueError(f"Rule {name!r} is defined twice or has no text.")
        RULES[name] = Rule(name, scope, " ".join(check.__doc__.split()), check)
        return check

    return register


def problems(scope: Scope, subject: Any) -> list[Problem]:
    """Every problem that the rules of a scope report for a subject."""
    return [
        Problem(rule.name, finding.where, finding.message, finding.hint)
        for rule in RULES.values()
        if rule.scope == scope
        for finding in rule.check(subject)
    ]
