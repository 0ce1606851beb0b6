"""What changed: releases from the changelog, and decisions on entries."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

from gym_extensions.scoring.scorecard import Scorecard
from gym_extensions.site import bundled
from gym_extensions.site.board_views import Leaderboard
from gym_extensions.site.pages.page import File, Render

CHANGELOG = bundled("changelog/CHANGELOG.md", "CHANGELOG.md")
START = "<!-- releases -->\n"
MAX_EVENTS = 100
"""Events on the page."""


def publish(site: Leaderboard, render: Render) -> Iterator[File]:
    """Entries and releases, the newest first."""
    history, events = releases(CHANGELOG), entry_events(site.entries)
    values = {"releases": history, "events": events[:MAX_EVENTS], "count": len(events)}
    yield "changes.html", render("changes.html", "changes.html", **values)


class Release(NamedTuple):
    """The changes of a version by kind, in Markdown; its date is empty if it is not released."""

    version: str
    date: str
    changes: tuple[tuple[str, tuple[str, ...]], ...]


def releases(file: Path) -> tuple[Release, ...]:
    """All releases of a changelog as they follow in it, the newest first; none without the file."""
    text = file.read_text(encoding="utf-8").partition(START)[2] if file.is_file() else ""
    found = []
    for section in re.split(r"^## ", text, flags=re.MULTILINE)[1:]:
        title, _, body = section.partition("\n")
        match = re.fullmatch(r"(\S+) \((\d{4}-\d\d-\d\d)\)", title.strip())
        version, date = match.groups() if match else (title.strip(), "")
        parts = re.split(r"^### ", body, flags=re.MULTILINE)[1:]
        found.append(Release(version, date, tuple(map(_part, parts))))
    return tuple(found)


def _part(text: str) -> tuple[str, tuple[str, ...]]:
    title, _, body = text.partition("\n")
    items = re.split(r"^- ", body, flags=re.MULTILINE)[1:]
    return title.strip(), tuple(" ".join(item.split()) for item in items)


class EntryEvent(NamedTuple):
    """A decision about an entry, such as ``Accepted``, and why."""

    name: str
    title: str
    date: str
    event: str
    reason: str


def entry_events(cards: Iterable[Scorecard]) -> tuple[EntryEvent, ...]:
    """Every decision about an entry, the newest first, then by name; the later of a day first."""
    events = [
        EntryEvent(card.name, card.title, decision.date, decision.action.capitalize(), decision.reason)
        for card in sorted(cards, key=lambda card: card.name)
        for decision in reversed(card.decisions)
    ]
    return tuple(sorted(events, key=lambda event: event.date, reverse=True))
