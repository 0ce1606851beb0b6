"""Which entries of a board are copies of another, and which are by the same authors with the same family."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Mapping, Sequence

from gym_extensions.scoring.entry.signs import SHARE, Sketch, is_common
from gym_extensions.scoring.ranking.boards import BoardKey, board_level, is_verified
from gym_extensions.scoring.scorecard import Scorecard

LAST_DATE = "9999"
"""Sorts after every date."""


def duplicates(cards: Sequence[Scorecard], key: BoardKey) -> dict[str, str]:
    """The original of each entry that is a copy, by name. Only sequential logs can show that.

    Methods that differ between tasks alone rightly have equal single-task logs, and joint training is the
    same for them. Of identical entries the original is a verified one, then the one that was accepted first,
    then the first by name.
    """
    if key.protocol != "sequential":
        return {}

    def original_first(card: Scorecard) -> tuple[bool, str, str]:
        return not is_verified(board_level(card, key)), card.accepted or LAST_DATE, card.name

    return duplicate_entries(
        {
            card.name: [
                tuple(f"{name} {digest}" for digest in sketch)  # groups of a suite are told apart
                for name in key.groups
                if (log := card.groups.get(name, {}).get(key.protocol))
                for sketch in log.episode_sketches
            ]
            for card in sorted(cards, key=original_first)
        }
    )


def duplicate_entries(entries: Mapping[str, Sequence[Sketch]]) -> dict[str, str]:
    """The original that shares most episodes with an entry, by the name of the later entry.

    Two entries share most episodes if half of the runs of either do: a copy with further runs, with changed
    runs or episodes, or without its training curves is still recognized.

    Args:
        entries: the sketches of the runs by the entry's name. Of entries that share most episodes, the first
            of the mapping is the original. Entries without runs share nothing.
    """
    holders: dict[str, list[str]] = defaultdict(list)
    copies: dict[str, str] = {}
    order = {name: index for index, name in enumerate(entries)}
    for name, sketches in entries.items():
        digests = {digest for sketch in sketches for digest in sketch}
        earlier = sorted({other for digest in digests for other in holders[digest]}, key=order.__getitem__)
        original = next((other for other in earlier if _share(sketches, entries[other])), None)
        if original is not None:
            copies[name] = original
            continue
        for digest in digests:
            holders[digest].append(name)
    return copies


def copy_of(original: str) -> str:
    """Why a copy has no rank."""
    return f"Has most episodes of {original}."


def _share(first: Sequence[Sketch], second: Sequence[Sketch]) -> bool:
    return any(
        sum(any(is_common(run, other) for other in theirs) for run in ours) >= SHARE * len(ours)
        for ours, theirs in ((first, second), (second, first))
    )


def family(algorithm: str) -> str:
    """The family of an algorithm: its name up to the first character that is not a letter or digit.

    >>> family("trpo-2017"), family("SAC_fresh_buffer")
    ('trpo', 'sac')
    """
    return re.split(r"[\W_]", algorithm.strip().casefold(), maxsplit=1)[0]


def related_entries(cards: Mapping[str, Scorecard]) -> dict[str, tuple[str, ...]]:
    """The names of the other entries with a common author and the same family, sorted, by name of the entry.

    Args:
        cards: scorecards of the entries of a board, by name.
    """
    names: dict[tuple[str, str], set[str]] = defaultdict(set)
    for name, card in cards.items():
        for author in card.manifest.authors if card.manifest else ():
            algorithm = family(card.manifest.protocol.algorithm) if card.manifest else ""
            names[" ".join(author.split()).casefold(), algorithm].add(name)
    related: dict[str, set[str]] = {name: set() for name in cards}
    for group in names.values():
        for name in group:
            related[name] |= group - {name}
    return {name: tuple(sorted(others)) for name, others in related.items()}
