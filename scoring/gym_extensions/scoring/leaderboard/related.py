"""Entries on one board by the same author with the same family of algorithms."""

from __future__ import annotations

import re
from collections.abc import Mapping

from gym_extensions.scoring.scorecard.model import Scorecard


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
    names: dict[tuple[str, str], set[str]] = {}
    for name, card in cards.items():
        if card.manifest is None:
            continue
        algorithm = family(card.manifest.protocol.algorithm)
        for author in card.manifest.authors:
            names.setdefault((" ".join(author.split()).casefold(), algorithm), set()).add(name)
    related: dict[str, set[str]] = {name: set() for name in cards}
    for group in names.values():
        for name in group:
            related[name] |= group - {name}
    return {name: tuple(sorted(others)) for name, others in related.items()}
