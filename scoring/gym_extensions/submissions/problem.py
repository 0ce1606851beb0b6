"""Rules, and the problems that they find: the broken rule, where, what is wrong and what to do."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, NamedTuple

from gym_extensions.errors import BenchError

PROBLEMS_LISTED = 20
"""Problems listed per rule and submission; the rest are counted."""
MAX_TEXT = 500
"""Characters of each text of a problem."""
MAX_QUOTE = 80
"""Characters of a quoted value."""


def escape(text: str) -> str:
    """The text with control and other unprintable characters as escape sequences."""
    if text.isprintable():
        return text
    return "".join(char if char.isprintable() else char.encode("unicode_escape").decode() for char in text)


def cut(text: str) -> str:
    """The text with at most ``MAX_TEXT`` characters."""
    return text if len(text) <= MAX_TEXT else f"{text[: MAX_TEXT - 1]}…"


def quote(value: object) -> str:
    """The ``repr`` of a value, cut to 80 characters."""
    cut = value[: MAX_QUOTE + 1] if isinstance(value, str) else value
    try:
        text = repr(cut)
    except ValueError:
        return "An integer with too many digits to print"
    return text if len(text) <= MAX_QUOTE else f"{text[:MAX_QUOTE]}…"


def count(number: int, word: str) -> str:
    """``1 run``, ``2 runs``."""
    return f"{number} {word}{'' if number == 1 else 's'}"


class Finding(NamedTuple):
    """A finding of a rule, with a path inside the submission (and line or key), what is wrong, what to do."""

    where: str
    message: str
    hint: str


@dataclass(frozen=True)
class Problem:
    """A finding and the name of the broken rule. Its texts contain printable characters only."""

    rule: str
    where: str
    message: str
    hint: str

    def __post_init__(self) -> None:
        for name in ("where", "message", "hint"):
            object.__setattr__(self, name, cut(escape(getattr(self, name)[: MAX_TEXT + 1])))


Scope = Literal[
    "folder", "file", "manifest", "readme", "agent", "document", "log", "policies", "pull request"
]
"""What a rule checks. The rules of a scope have the same parameters."""
Check = Callable[..., Iterator[Finding]]


class Rule(NamedTuple):
    """A rule, with its name in kebab case, its scope, its text and its function.

    Who reads a file reports that it cannot be read: rules of the scope ``file`` have no function.
    """

    name: str
    scope: Scope
    text: str
    check: Check | None = None


RULES: dict[str, Rule] = {}
"""Every rule by name, in the order in which they are checked within a scope. ``rules`` fills it."""


def rule(scope: Scope, rules: dict[str, Rule] = RULES) -> Callable[[Check], Check]:
    """Registers a function as a rule with the function's name. Its docstring is the rule's text."""

    def register(check: Check) -> Check:
        name, text = check.__name__.replace("_", "-"), " ".join((check.__doc__ or "").split())
        rules[name] = Rule(name, scope, text, check)
        return check

    return register


def problems(scope: Scope, *subject: object, rules: Mapping[str, Rule] = RULES) -> list[Problem]:
    """Every problem that the rules of a scope report for a subject, their arguments."""
    chosen = (rule for rule in rules.values() if rule.scope == scope)
    checks = [(rule.name, rule.check) for rule in chosen if rule.check]
    return [Problem(name, *found) for name, check in checks for found in check(*subject)]


def refuse_problems(folder: Path, problems: Sequence[Problem]) -> None:
    """Raises ``BenchError`` if a submission has problems."""
    if problems:
        first = f"{problems[0].where}: {problems[0].message} {problems[0].hint}"
        message = f"The submission has {count(len(problems), 'problem')}. First: {first}"
        raise BenchError("not-valid", message, str(folder), f"Run: score {folder}")


def summarize(problems: Sequence[Problem], name: str) -> tuple[Problem, ...]:
    """The first ``PROBLEMS_LISTED`` problems per rule, then one per rule, of the submission, for the rest."""
    by_rule: dict[str, list[Problem]] = {}
    listed = []
    for problem in problems:
        found = by_rule.setdefault(problem.rule, [])
        found.append(problem)
        if len(found) <= PROBLEMS_LISTED:
            listed.append(problem)
    for rule, found in by_rule.items():
        if (more := len(found) - PROBLEMS_LISTED) > 0:
            listed.append(Problem(rule, name, f"{count(more, 'more problem')} of this rule.", found[0].hint))
    return tuple(listed)
