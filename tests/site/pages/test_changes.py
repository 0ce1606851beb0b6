"""The page of changes: releases, and decisions on entries."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from gym_extensions.site.pages.changes import Release, entry_events, releases

from ..browser import typed

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
