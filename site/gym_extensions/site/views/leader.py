"""The first entry of a board, and a sentence on how certain its lead is."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from gym_extensions.scoring.leaderboard.model import BoardEntry, VersusNext
from gym_extensions.site.text.names import short
from gym_extensions.site.text.numbers import fixed
from gym_extensions.site.views.board_row import Row

MOST_NAMED = 3
"""Up to this many overlapping entries are named; more are counted."""


class Leader(NamedTuple):
    """The first entry of a board, and how certain its lead is, in a sentence."""

    row: Row
    certainty: str


def leader(rows: Sequence[Row], metric: str) -> Leader | None:
    """The first entry and how certain its lead is; None if no entry has a score.

    Ranked entries are compared by the scorer's rank intervals, others by their intervals.

    Args:
        rows: a board's rows from top to bottom.
        metric: the name of the metric that sorts it.
    """
    scored = [row for row in rows if row.score.mean is not None]
    ranked = [row for row in scored if row.ranked]
    if not scored:
        return None
    return Leader(ranked[0], _ranked(ranked, metric)) if ranked else Leader(scored[0], _unranked(scored))


def _ranked(ranked: Sequence[Row], metric: str) -> str:
    first, *others = ranked
    if not others:
        return "It is the only ranked entry."
    tied = first.tied(metric)
    if not tied:
        return "It is significantly better than every other ranked entry (95\u202f% confidence)."
    return f"A tie at the top of {tied + 1} entries. " + _versus(others[0].entry, first.entry.vs_next)


def _versus(second: BoardEntry, comparison: VersusNext | None) -> str:
    """How the first entry compares with the second, in the digits that the page shows."""
    if comparison is None:
        raise ValueError("A ranked entry above another one has no comparison with it.")
    difference, name = comparison.difference, f"{short(second.title)} ({second.name})"
    size = fixed(difference.mean)
    if comparison.separated:
        size = "less than 0.01" if size == fixed(0.0) else size
        return f"It is significantly better than {name}, by {size}, but not than all others."
    if difference.low is None or difference.high is None:
        return f"Its distance to {name} is {size}."
    return (
        f"Its distance to {name} is {size}, and could be anything from {fixed(difference.low)} to "
        f"{fixed(difference.high)}."
    )


def _unranked(scored: Sequence[Row]) -> str:
    first, *others = scored
    if not others:
        return "It is the only entry with a score."
    if first.score.ends is None:
        return "It has one run, so its uncertainty is unknown."
    low = first.score.ends[0]
    overlapping = [f"{short(row.entry.title)} ({row.entry.name})" for row in others if _top(row) >= low]
    if overlapping:
        names = f"{len(overlapping)} others" if len(overlapping) > MOST_NAMED else _listed(overlapping)
        return f"Its interval overlaps with {names}, so the order may be due to chance."
    if any(row.score.ends is None for row in others):
        return "Its interval lies above the intervals and single runs of all other entries."
    return "Its interval lies above the intervals of all other entries."


def _top(row: Row) -> float:
    """The upper end of an entry's interval, or the value of its single run."""
    return row.score.ends[1] if row.score.ends else row.score.mean or 0.0


def _listed(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
