"""What is wrong with a submission, as data: every problem names its rule, its place and what to do."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Numbers = NDArray[np.int64]

ROWS_TOLD = 3
"""Rows named one by one for each rule and file; the others are counted."""


LONGEST_QUOTE = 80


def printable(text: str) -> str:
    """The text with an escape in the place of everything that a terminal would obey or cannot show."""
    if text.isprintable():
        return text
    return "".join(one if one.isprintable() else one.encode("unicode_escape").decode() for one in text)


def shown(value: object) -> str:
    """A value as it is quoted to its author: at most 80 characters."""
    cut = value[: LONGEST_QUOTE + 1] if isinstance(value, str) else value
    try:
        text = repr(cut)
    except ValueError:
        return "a number of very many digits"
    return text if len(text) <= LONGEST_QUOTE else f"{text[:LONGEST_QUOTE]}…"


@dataclass(frozen=True)
class Finding:
    """What a rule found: where (a path inside the submission, with a row), what, and what to do about it."""

    where: str
    message: str
    hint: str


@dataclass(frozen=True)
class Problem:
    """A finding with the name of the rule that was broken; its texts hold printable characters alone."""

    rule: str
    where: str
    message: str
    hint: str

    def __post_init__(self) -> None:
        for name in ("where", "message", "hint"):
            object.__setattr__(self, name, printable(getattr(self, name)))

    def as_dict(self) -> dict[str, str]:
        """The four keys of the scorecard's JSON."""
        return {"rule": self.rule, "where": self.where, "message": self.message, "hint": self.hint}


def number(row: int, numbers: Numbers | None = None) -> int:
    """The number of a data row in its file (the header is row 1) by its index among those that are there."""
    return 2 + (row if numbers is None else int(numbers[row]))


def told_briefly(problems: Sequence[Problem]) -> list[Problem]:
    """The first problems of each rule, then for each rule one that counts the rest of its places."""
    by_rule: dict[str, list[Problem]] = {}
    for one in problems:
        by_rule.setdefault(one.rule, []).append(one)
    brief: list[Problem] = []
    for rule, found in by_rule.items():
        brief += found[:ROWS_TOLD]
        rest = found[ROWS_TOLD:]
        if rest:
            places = "1 more place breaks" if len(rest) == 1 else f"{len(rest)} more places break"
            where = rest[0].where.partition("/")[0]
            brief.append(Problem(rule, where, f"{places} the same rule.", rest[0].hint))
    return brief


def told(
    path: str,
    rows: Sequence[int],
    say: Callable[[int], str],
    hint: str,
    numbers: Numbers | None = None,
    *,
    more: int = 0,
) -> Iterator[Finding]:
    """One finding for each of the first rows, then one that counts the rest.

    Args:
        path: the file inside the submission.
        rows: indices of the data rows that are wrong, from 0.
        say: what was found in the row of that index.
        hint: what to do.
        numbers: each row's place in the file, from 0; the row's index where None.
        more: how many wrong rows there are beside ``rows``.
    """
    for index in rows[:ROWS_TOLD]:
        yield Finding(f"{path}, row {number(index, numbers)}", say(index), hint)
    rest = len(rows[ROWS_TOLD:]) + more
    if rest:
        yield Finding(
            path, f"{rest} more row{'s' if rest > 1 else ''} of this file break the same rule.", hint
        )
