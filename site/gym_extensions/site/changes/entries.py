"""What the ledger says of the entries that the site shows, the newest first."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from gym_extensions.scoring.scorecard.model import Scorecard

EVENTS = {
    "accepted": "Accepted",
    "rescored": "Scored again",
    "challenged": "Challenged",
    "superseded": "Superseded",
    "withdrawn": "Withdrawn",
}


@dataclass(frozen=True)
class EntryEvent:
    """The last line of the ledger about an entry.

    Args:
        name: the folder of the entry.
        title: its title.
        date: YYYY-MM-DD.
        event: what happened, for example ``Accepted``.
        reason: the sentence of the line.
        digest: of the entry's files.
    """

    name: str
    title: str
    date: str
    event: str
    reason: str
    digest: str


def entry_events(cards: Iterable[Scorecard]) -> tuple[EntryEvent, ...]:
    """One event per entry that the ledger has, by date and name, the newest first."""
    events = [
        EntryEvent(
            card.name,
            card.title,
            card.ledger.date,
            EVENTS[card.ledger.event],
            card.ledger.reason,
            card.ledger.digest,
        )
        for card in cards
        if card.ledger and not card.ledger.is_pending
    ]
    by_name = sorted(events, key=lambda event: event.name)
    return tuple(sorted(by_name, key=lambda event: event.date, reverse=True))
