"""What is wrong with a submission, as data: every problem names its rule, its place and what to do."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

ROWS_TOLD = 3
"""Rows named one by one for each rule and file; the others are counted."""


@dataclass(frozen=True)
class Finding:
    """What a rule found: where (a path inside the submission, with a row), what, and what to do about it."""

    where: str
    message: str
    hint: str


@dataclass(frozen=True)
class Problem:
    """A finding with the name of the rule that was broken."""

    rule: str
    where: str
    message: str
    hint: str

    def as_dict(self) -> dict[str, str]:
        """The four keys of the scorecard's JSON."""
        return {"rule": self.rule, "where": self.where, "message": self.message, "hint": self.hint}


def told(path: str, rows: Sequence[int], say: Callable[[int], str], hint: str) -> Iterator[Finding]:
    """One finding for each of the first rows, then one that counts the rest.

    Args:
        path: the file inside the submission.
        rows: indices of the data rows that are wrong, from 0 (the header is row 1 of the file).
        say: what was found in the row of that index.
        hint: what to do.
    """
    for index in rows[:ROWS_TOLD]:
        yield Finding(f"{path}, row {index + 2}", say(index), hint)
    more = len(rows) - ROWS_TOLD
    if more > 0:
        yield Finding(
            path, f"{more} more row{'s' if more > 1 else ''} of this file break the same rule.", hint
        )
