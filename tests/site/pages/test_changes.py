"""The page of changes and its feed: releases, and decisions on entries."""

from __future__ import annotations

from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import pytest

from gym_extensions.site.pages.changes import EntryEvent, Release, entry_events, feed, releases

from ..browser import files, typed

CHANGELOG = """# Changelog

<!-- releases -->
## 1.1.0 (2027-02-01)

### Scores

- A score moved.

### Added

- A page with `code`.
- Another.

## 1.0.0 (2026-12-01)

### Added

- Everything.
"""
EVENT = EntryEvent("agile", "Agile", "2026-11-22", "Accepted", "A reason.")


@pytest.fixture
def changelog_file(tmp_path: Path) -> Path:
    (tmp_path / "CHANGELOG.md").write_text(CHANGELOG, encoding="utf-8")
    return tmp_path / "CHANGELOG.md"


def test_releases_have_their_changes_by_kind(changelog_file: Path) -> None:
    assert releases(changelog_file) == (
        Release(
            "1.1.0",
            "2027-02-01",
            (("Scores", ("A score moved.",)), ("Added", ("A page with `code`.", "Another."))),
        ),
        Release("1.0.0", "2026-12-01", (("Added", ("Everything.",)),)),
    )


ATOM = "http://www.w3.org/2005/Atom"


def test_the_feed_has_releases_and_events_by_date(changelog_file: Path) -> None:
    items = feed(releases(changelog_file), (EVENT,))
    assert [(item.date, item.title, item.link) for item in items] == [
        ("2027-02-01", "gym-extensions 1.1.0", "changes.html"),
        ("2026-12-01", "gym-extensions 1.0.0", "changes.html"),
        ("2026-11-22", "Accepted: Agile (agile)", "submissions/agile.html"),
    ]
    assert len({item.id for item in items}) == 3
    assert items[2].id == feed((), (EVENT,))[0].id, "the identifier of an event follows from it alone"


@pytest.mark.parametrize("title", ["<b>&amp;", "\N{CJK UNIFIED IDEOGRAPH-7B97} ]]>", "\ufffe\x00"])
def test_every_title_makes_a_valid_document(document: dict[str, Any], title: str) -> None:
    document["submissions"][0]["title"] = title
    decided(document, 0, "accepted", "2126-11-22")
    root = ET.fromstring(dict(files(document))["feed.xml"])
    assert root.findtext(f"{{{ATOM}}}updated") == "2126-11-22T00:00:00Z"
    assert str(root.findtext(f"{{{ATOM}}}entry/{{{ATOM}}}title")).startswith("Accepted: ")


def decided(document: dict[str, Any], index: int, action: str, date: str) -> None:
    """Adds a decision to an entry of the document."""
    decision = {"action": action, "by": "maintainer", "date": date, "reason": "A reason."}
    document["submissions"][index].setdefault("decisions", []).append(decision)


def test_events_are_decisions_newest_first(document: dict[str, Any]) -> None:
    decided(document, 0, "accepted", "2026-11-20")
    decided(document, 1, "withdrawn", "2026-11-21")
    decided(document, 0, "challenged", "2026-11-22")
    events = entry_events(typed(document).submissions)
    assert [(event.name, event.event) for event in events] == [
        ("agile", "Challenged"),
        ("keeper", "Withdrawn"),
        ("agile", "Accepted"),
    ]
