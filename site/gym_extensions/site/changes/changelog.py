"""Reads the releases of CHANGELOG.md and the fragments of changelog.d.

In a wheel they lie in ``gym_extensions/site/changelog``; in the source tree at its top.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

SITE = Path(__file__).parents[1]
START = "<!-- towncrier release notes start -->\n"
KINDS = {
    "scores": "Scores",
    "added": "Added",
    "changed": "Changed",
    "fixed": "Fixed",
    "removed": "Removed",
}
"""The kinds of changes in the order of the page, as in ``[tool.towncrier]``."""


@dataclass(frozen=True)
class Release:
    """The changes of a version by kind.

    Args:
        version: its name; empty for changes that are not released yet.
        date: YYYY-MM-DD; empty if not released.
        changes: heading and texts, in Markdown.
    """

    version: str
    date: str
    changes: tuple[tuple[str, tuple[str, ...]], ...]


def folder() -> Path:
    """The folder with CHANGELOG.md and changelog.d."""
    packaged = SITE / "changelog"
    return packaged if packaged.is_dir() else SITE.parents[2]


def releases(top: Path) -> tuple[Release, ...]:
    """All releases, the newest first; before them the changes that are not released, if there are any."""
    by_kind: dict[str, list[str]] = {kind: [] for kind in KINDS}
    for file in sorted((top / "changelog.d").glob("*.*.md")):
        kind = file.name.split(".")[-2]
        if kind in by_kind:
            by_kind[kind].append(" ".join(file.read_text(encoding="utf-8").split()))
    changes = tuple((KINDS[kind], tuple(texts)) for kind, texts in by_kind.items() if texts)
    file = top / "CHANGELOG.md"
    text = file.read_text(encoding="utf-8") if file.is_file() else ""
    return (*((Release("", "", changes),) if changes else ()), *_released(text.partition(START)[2]))


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
