"""What changed: releases from the changelog, decisions on entries, and both as an Atom feed."""

from __future__ import annotations

import re
import uuid
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree as ET

from gym_extensions.scoring.scorecard import Scorecard
from gym_extensions.site.api import entry_path

START = "<!-- releases -->\n"
ACTIONS = {"accepted": "Accepted", "challenged": "Challenged", "withdrawn": "Withdrawn"}


@dataclass(frozen=True)
class Release:
    """The changes of a version by kind.

    Args:
        version: its name.
        date: YYYY-MM-DD; empty if not released.
        changes: heading and texts, in Markdown.
    """

    version: str
    date: str
    changes: tuple[tuple[str, tuple[str, ...]], ...]


def changelog() -> Path:
    """CHANGELOG.md: beside this module in a wheel, at the top of the source tree."""
    packaged = Path(__file__).parent / "changelog" / "CHANGELOG.md"
    return packaged if packaged.is_file() else Path(__file__).parents[3] / "CHANGELOG.md"


def releases(file: Path) -> tuple[Release, ...]:
    """All releases of a changelog as they follow in it, the newest first; none without the file."""
    text = file.read_text(encoding="utf-8") if file.is_file() else ""
    return tuple(_released(text.partition(START)[2]))


def _released(text: str) -> Iterator[Release]:
    for section in re.split(r"^## ", text, flags=re.MULTILINE)[1:]:
        title, _, body = section.partition("\n")
        match = re.fullmatch(r"(\S+) \((\d{4}-\d\d-\d\d)\)", title.strip())
        version, date = match.groups() if match else (title.strip(), "")
        parts = re.split(r"^### ", body, flags=re.MULTILINE)[1:]
        yield Release(version, date, tuple(_part(part) for part in parts))


def _part(text: str) -> tuple[str, tuple[str, ...]]:
    title, _, body = text.partition("\n")
    items = re.split(r"^- ", body, flags=re.MULTILINE)[1:]
    return title.strip(), tuple(" ".join(item.split()) for item in items)


@dataclass(frozen=True)
class EntryEvent:
    """A decision about an entry.

    Args:
        name: the folder of the entry.
        title: its title.
        date: YYYY-MM-DD.
        event: what was decided, for example ``Accepted``.
        reason: why.
    """

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


ATOM = "http://www.w3.org/2005/Atom"
SPACE = uuid.UUID("6f0d3a3e-7f5e-5f0b-9a37-2c1d54a0b6ce")
"""The namespace of the identifiers; it never changes, or readers see every item again."""
FIRST_DAY = "2026-01-01"
"""The date of a feed without items."""
MAX_ITEMS = 50
NOT_XML = re.compile(r"[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""Characters that an XML document cannot contain, not even escaped."""


def feed(releases: Sequence[Release], events: Sequence[EntryEvent]) -> str:
    """The newest 50 releases and events as an Atom document; the same input gives the same bytes."""
    items = [
        (release.date, f"gym-extensions {release.version}", "changes.html", _text(release), release.version)
        for release in releases
        if release.date
    ]
    items += [
        (
            event.date,
            f"{event.event}: {event.title} ({event.name})",
            entry_path(event.name),
            event.reason,
            f"{event.event} {event.name} {event.date} {event.reason}",
        )
        for event in events
    ]
    items = sorted(items, key=lambda item: item[0], reverse=True)[:MAX_ITEMS]
    root = ET.Element("feed", {"xmlns": ATOM})
    _add(root, "title", "gym-extensions: changes and entries")
    _add(root, "id", _urn("feed"))
    _add(root, "updated", _time(items[0][0] if items else FIRST_DAY))
    ET.SubElement(root, "link", {"rel": "self", "href": "feed.xml"})
    ET.SubElement(root, "link", {"rel": "alternate", "href": "changes.html"})
    _add(ET.SubElement(root, "author"), "name", "The gym-extensions authors")
    for date, title, link, text, key in items:
        entry = ET.SubElement(root, "entry")
        _add(entry, "title", title)
        _add(entry, "id", _urn(key))
        _add(entry, "updated", _time(date))
        ET.SubElement(entry, "link", {"rel": "alternate", "href": link})
        _add(entry, "summary", text)
    ET.indent(root, " ")
    return ET.tostring(root, encoding="unicode", xml_declaration=False) + "\n"


def _text(release: Release) -> str:
    return "\n".join(f"{kind}: {' '.join(texts)}" for kind, texts in release.changes)


def _add(parent: ET.Element, tag: str, text: str) -> None:
    ET.SubElement(parent, tag).text = NOT_XML.sub("\N{REPLACEMENT CHARACTER}", text)


def _urn(key: str) -> str:
    return f"urn:uuid:{uuid.uuid5(SPACE, key)}"


def _time(date: str) -> str:
    return f"{date}T00:00:00Z"
