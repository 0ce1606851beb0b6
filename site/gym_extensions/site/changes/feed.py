"""The Atom feed (RFC 4287) of releases and entries.

Its identifiers are URNs that follow from names, and its links are relative to the address of the feed, so
that the same file works at every address.
"""

from __future__ import annotations

import re
import uuid
from collections.abc import Sequence
from xml.etree import ElementTree as ET

from gym_extensions.site.addresses import entry_path
from gym_extensions.site.changes.changelog import Release
from gym_extensions.site.changes.entries import EntryEvent

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
            f"{event.event} {event.name} {event.digest} {event.date}",
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
