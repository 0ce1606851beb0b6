"""Entries that share most of their episodes with another entry."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence

from gym_extensions.scoring.scorecard.sketches import SIZE, Sketch

SHARE = 0.5
"""Least share of common episodes of two runs, and of such runs of an entry, that makes it a duplicate."""


def is_common(first: Sketch, second: Sketch) -> bool:
    """Whether two runs share at least half of their episodes, as estimated from their sketches."""
    union = sorted({*first, *second})[:SIZE]
    return bool(union) and len({*first} & {*second} & {*union}) >= SHARE * len(union)


def duplicate_entries(entries: Mapping[str, Sequence[Sketch]]) -> dict[str, str]:
    """The first other entry, by name, that shares most episodes with an entry, by name of the entry.

    Two entries share most episodes if half of the runs of either do: a copy with further runs, with changed
    runs or episodes, or without its training curves is still recognized.

    Args:
        entries: the sketches of the runs by the entry's name. Entries without runs share nothing.
    """
    holders: dict[str, set[str]] = defaultdict(set)
    for name, sketches in entries.items():
        for sketch in sketches:
            for digest in sketch:
                holders[digest].add(name)
    others: dict[str, set[str]] = {name: set() for name in entries}
    for names in holders.values():
        for name in names:
            others[name] |= names - {name}
    return {
        name: match
        for name in entries
        if (match := next((o for o in sorted(others[name]) if _share(entries[name], entries[o])), ""))
    }


def _share(first: Sequence[Sketch], second: Sequence[Sketch]) -> bool:
    return any(
        sum(any(is_common(run, other) for other in theirs) for run in ours) >= SHARE * len(ours)
        for ours, theirs in ((first, second), (second, first))
    )
