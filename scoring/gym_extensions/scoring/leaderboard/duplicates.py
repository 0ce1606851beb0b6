"""Entries that share most of their episodes with another entry."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence

from gym_extensions.scoring.scorecard.sketches import SHARE, Sketch, is_common


def duplicate_entries(entries: Mapping[str, Sequence[Sketch]]) -> dict[str, str]:
    """The original that shares most episodes with an entry, by the name of the later entry.

    Two entries share most episodes if half of the runs of either do: a copy with further runs, with changed
    runs or episodes, or without its training curves is still recognized.

    Args:
        entries: the sketches of the runs by the entry's name. Of entries that share most episodes, the first
            of the mapping is the original. Entries without runs share nothing.
    """
    holders: dict[str, list[str]] = defaultdict(list)
    duplicates: dict[str, str] = {}
    order = {name: index for index, name in enumerate(entries)}
    for name, sketches in entries.items():
        digests = {digest for sketch in sketches for digest in sketch}
        earlier = sorted({other for digest in digests for other in holders[digest]}, key=order.__getitem__)
        original = next((other for other in earlier if _share(sketches, entries[other])), None)
        if original is not None:
            duplicates[name] = original
            continue
        for digest in digests:
            holders[digest].append(name)
    return duplicates


def _share(first: Sequence[Sketch], second: Sequence[Sketch]) -> bool:
    return any(
        sum(any(is_common(run, other) for other in theirs) for run in ours) >= SHARE * len(ours)
        for ours, theirs in ((first, second), (second, first))
    )
