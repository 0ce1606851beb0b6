"""A problem in a submission states the broken rule, the location, what is wrong and what to do."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

RowNumbers = NDArray[np.int64]

ROWS_LISTED = 3
"""Rows listed per rule and file; the rest are counted."""
PROBLEMS_LISTED = 20
"""Problems listed per rule and submission; the rest are counted."""
MAX_LISTED = 200
"""Problems listed per submission; if there are more, fewer are listed per rule."""
MAX_TEXT = 500
"""Characters of each text of a problem."""
MAX_QUOTE = 80
"""Characters of a quoted value."""


def escape(text: str) -> str:
    """The text with control and other unprintable characters as escape sequences."""
    if text.isprintable():
        return text
    return "".join(char if char.isprintable() else char.encode("unicode_escape").decode() for char in text)


def quote(value: object) -> str:
    """The ``repr`` of a value, cut to 80 characters."""
    cut = value[: MAX_QUOTE + 1] if isinstance(value, str) else value
    try:
        text = repr(cut)
    except ValueError:
        return "An integer with too many digits to print"
    return text if len(text) <= MAX_QUOTE else f"{text[:MAX_QUOTE]}…"


@dataclass(frozen=True)
class Finding:
    """A finding of a rule, with a path inside the submission (and row or key), what is wrong, what to do."""

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
            text = escape(getattr(self, name)[: MAX_TEXT + 1])
            object.__setattr__(self, name, text if len(text) <= MAX_TEXT else f"{text[: MAX_TEXT - 1]}…")

    def as_dict(self) -> dict[str, str]:
        """The problem as in the scorecard's JSON."""
        return {"rule": self.rule, "where": self.where, "message": self.message, "hint": self.hint}


def row_number(index: int, numbers: RowNumbers | None = None) -> int:
    """The number of a data row in its file, where the header is row 1.

    Args:
        index: the row's index among the rows that were read, from 0.
        numbers: the index in the file of each row that was read; None if all rows were read.
    """
    return 2 + (index if numbers is None else int(numbers[index]))


def row_findings(
    path: str,
    rows: Sequence[int],
    message: Callable[[int], str],
    hint: str,
    numbers: RowNumbers | None = None,
    *,
    more: int = 0,
) -> Iterator[Finding]:
    """One finding per row for the first ``ROWS_LISTED`` rows, then one that counts the rest.

    Args:
        path: the file inside the submission.
        rows: indices of the rows that break the rule.
        message: what is wrong with the row of an index.
        hint: what to do.
        numbers: as for ``row_number``.
        more: number of rows that break the rule and are not in ``rows``.
    """
    for index in rows[:ROWS_LISTED]:
        yield Finding(f"{path}, row {row_number(index, numbers)}", message(index), hint)
    further = len(rows[ROWS_LISTED:]) + more
    if further:
        subject = (
            "1 more row of this file breaks" if further == 1 else f"{further} more rows of this file break"
        )
        yield Finding(path, f"{subject} the same rule.", hint)


def summarize(problems: Sequence[Problem], name: str) -> tuple[Problem, ...]:
    """The first ``PROBLEMS_LISTED`` problems per rule, then one per rule that counts the rest.

    If these are more than ``MAX_LISTED``, fewer per rule.

    Args:
        problems: all problems of a submission.
        name: the submission's name; the counts are reported there.
    """
    listed: list[Problem] = []
    counts: list[Problem] = []
    totals = Counter(problem.rule for problem in problems)
    seen: Counter[str] = Counter()
    limits = range(PROBLEMS_LISTED, 1, -1)
    limit = next((n for n in limits if sum(min(total, n) for total in totals.values()) <= MAX_LISTED), 1)
    for problem in problems:
        seen[problem.rule] += 1
        more = totals[problem.rule] - limit
        if seen[problem.rule] <= limit:
            listed.append(problem)
        elif seen[problem.rule] == limit + 1:
            message = f"{more} more problem{'s' if more > 1 else ''} of this rule in the submission."
            counts.append(Problem(problem.rule, name, message, problem.hint))
    return (*listed, *counts)
