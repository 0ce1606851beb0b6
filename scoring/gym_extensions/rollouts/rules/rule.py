"""What a rule is: a function from what it looks at to what it found, registered under its own name."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from gym_extensions.rollouts.problem import Finding, Problem

Check = Callable[[Any], Iterator[Finding]]


@dataclass(frozen=True)
class Rule:
    """A rule: its name in kebab case, what it looks at, its text, its function."""

    name: str
    scope: str
    text: str
    check: Check


RULES: dict[str, Rule] = {}
"""Every rule by its name, in the order in which they are checked."""


def rule(scope: str) -> Callable[[Check], Check]:
    """Registers a function as a rule of that scope; its name is the rule's, its docstring the rule's text."""

    def register(check: Check) -> Check:
        name = check.__name__.replace("_", "-")
        if name in RULES or not check.__doc__:
            raise ValueError(f"Rule {name!r} is defined twice or has no text.")
        RULES[name] = Rule(name, scope, " ".join(check.__doc__.split()), check)
        return check

    return register


def broken(scope: str, subject: Any) -> list[Problem]:
    """Every problem that the rules of a scope find in a subject."""
    return [
        Problem(one.name, found.where, found.message, found.hint)
        for one in RULES.values()
        if one.scope == scope
        for found in one.check(subject)
    ]
