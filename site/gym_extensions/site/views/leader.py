"""Who is first on a board, and how sure that is: a sentence that is never surer than the runs."""

from __future__ import annotations

from collections.abc import Sequence

from gym_extensions.scoring.leaderboard.model import VersusNext
from gym_extensions.site.text.numbers import fixed, interval
from gym_extensions.site.views.board_row import Row


def lead(rows: Sequence[Row], metric: str) -> tuple[Row, str] | None:
    """The first row and how sure its lead is; None when nobody has a value.

    Ranked entries have the scorer's rank interval; where there are none, intervals are compared.

    Args:
        rows: a board's rows from top to bottom.
        metric: the name of the metric that sorts it.
    """
    valued = [row for row in rows if row.lead.mean is not None]
    ranked = [row for row in valued if row.ranked]
    if not valued:
        return None
    return (ranked[0], _ranked(ranked, metric)) if ranked else (valued[0], _unranked(valued))


def _ranked(ranked: Sequence[Row], metric: str) -> str:
    first, *others = ranked
    if not others:
        return "It is the only ranked entry."
    span = first.rank(metric) or (1, len(ranked))
    if span == (1, 1):
        return "It is ahead of every other ranked entry, with 95\u202f% confidence."
    start = f"It may rank from {span[0]} to {span[1]}: "
    return start + _against(others[0].entry.title, first.entry.vs_next)


def _against(second: str, below: VersusNext | None) -> str:
    """How it stands against the second: apart, level as far as two digits show, or ahead for now."""
    if below is None:
        raise ValueError("A ranked entry above another one has no comparison with it.")
    gap, more = below.difference, below.more_runs
    ends = "" if gap.low is None or gap.high is None else interval(gap.low, gap.high)
    level = fixed(gap.mean) == fixed(0.0)
    by = "less than 0.01" if level else fixed(gap.mean) + (f" ({ends})" if ends else "")
    if below.separated:
        return f"ahead of {second} by {by}, which is told apart, but not of all others."
    needed = "more than 100 more runs" if more is None else f"about {more} more run{'' if more == 1 else 's'}"
    if level:
        between = f" (difference {ends})" if ends else ""
        return f"it and {second} are level{between}; to tell them apart would take {needed} each."
    return f"ahead of {second} by {by}, which {needed} each would tell apart."


def _unranked(valued: Sequence[Row]) -> str:
    first, *others = valued
    if not others:
        return "It is the only entry with a value."
    if first.lead.ends is None:
        return "It has one run, so nothing can be said about how sure that is."
    low = first.lead.ends[0]
    touching = [row.entry.title for row in others if _top(row) >= low]
    if not touching:
        single = any(row.lead.ends is None for row in others)
        return (
            f"Its interval lies above that of every other entry{', or above its one run' if single else ''}."
        )
    listed = f"{len(touching)} others" if len(touching) > 3 else _listed(touching)
    return f"Its interval does not lie clear of {listed}, so the order may be chance."


def _top(row: Row) -> float:
    """How far up an entry may reach: the end of its interval, or its one run."""
    return row.lead.ends[1] if row.lead.ends else row.lead.mean or 0.0


def _listed(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
