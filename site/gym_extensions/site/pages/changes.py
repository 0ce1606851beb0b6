"""What changed: releases from the changelog, decisions on entries, and both as an Atom feed."""

from __future__ import annotations

import re
import uuid
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from gym_extensions.scoring.scorecard import Scorecard
from gym_extensions.site import bundled
from gym_extensions.site.board_views import Leaderboard
from gym_extensions.site.pages.page import File, Render
from gym_extensions.site.paths import entry_path

CHANGELOG = bundled("changelog/CHANGELOG.md", "CHANGELOG.md")
START = "<!-- releases -->\n"
MAX_EVENTS = 100
"""Events on the page; the feed has the newest ``MAX_ITEMS``."""
ACTIONS = {"accepted": "Accepted", "challenged": "Challenged", "withdrawn": "Withdrawn"}


def publish(site: Leaderboard, render: Render) -> Iterator[File]:
    """What changed: entries, releases, and both as an Atom feed."""
    history, events = releases(CHANGELOG), entry_events(site.entries)
    values = {"releases": history, "events": events[:MAX_EVENTS], "count": len(events)}
    yield "changes.html", render("changes.html", "changes.html", **values)
    items = feed(history, events)
    updated = items[0].date if items else FIRST_DAY
    yield "feed.xml", render("feed.xml", "feed.xml", items=items, updated=updated, id=urn("feed"))


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
        EntryEvent(card.name, card.title, decision.date, ACTIONS[decision.action], decision.reason)
        for card in sorted(cards, key=lambda card: card.name)
        for decision in reversed(card.decisions)
    ]
    return tuple(sorted(events, key=lambda event: event.date, reverse=True))


SPACE = uuid.UUID("6f0d3a3e-7f5e-5f0b-9a37-2c1d54a0b6ce")
"""The namespace of the identifiers; it never changes, or readers see every item again."""
FIRST_DAY = "2026-01-01"
"""The date of a feed without items."""
MAX_ITEMS = 50
NOT_XML = re.compile(r"[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""Characters that an XML document cannot contain, not even escaped."""


class Item(NamedTuple):
    """An item of the feed."""

    date: str
    title: str
    link: str
    text: str
    id: str


def feed(releases: Sequence[Release], events: Sequence[EntryEvent]) -> list[Item]:
    """The newest 50 releases and events, for the Atom document."""
    items = [
        Item(
            release.date,
            f"gym-extensions {release.version}",
            "changes.html",
            "\n".join(f"{kind}: {' '.join(texts)}" for kind, texts in release.changes),
            urn(release.version),
        )
        for release in releases
        if release.date
    ]
    for event in events:
        title = xml_text(f"{event.event}: {event.title} ({event.name})")
        key = urn(f"{event.event} {event.name} {event.date} {event.reason}")
        items.append(Item(event.date, title, entry_path(event.name), xml_text(event.reason), key))
    return sorted(items, key=lambda item: item.date, reverse=True)[:MAX_ITEMS]


def xml_text(text: str) -> str:
    """A text without the characters that XML excludes."""
    return NOT_XML.sub("\N{REPLACEMENT CHARACTER}", text)


def urn(key: str) -> str:
    """The identifier of an item of the feed."""
    return f"urn:uuid:{uuid.uuid5(SPACE, key)}"
