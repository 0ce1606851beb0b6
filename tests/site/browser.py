"""Reads the built pages as a browser does, and records errors in their markup."""

from __future__ import annotations

import re
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import msgspec

from gym_extensions.scoring.scorecard.model import ScorecardDocument
from gym_extensions.site.build import TASK_PAGES
from gym_extensions.site.build import files as site_files
from gym_extensions.site.page import pages

VOID = {"meta", "link", "br", "col", "wbr", "img", "input", "hr"}
SELF_CLOSING = {"line", "circle", "polygon", "polyline", "rect", "path"}


class Reader(HTMLParser):
    """A strict parser: every element is closed, in order."""

    def __init__(self, markup: str) -> None:
        super().__init__(convert_charrefs=True)
        self.open: list[str] = []
        self.errors: list[str] = []
        self.ids: list[str] = []
        self.elements: list[tuple[str, dict[str, str]]] = []
        self.words: list[str] = []
        self.feed(markup)
        self.close()
        self.errors += [f"<{tag}> is never closed" for tag in self.open]

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        names = [name for name, _ in attrs]
        self.errors += [f"{name} is repeated in <{tag}>" for name in set(names) if names.count(name) > 1]
        self.elements.append((tag, {name: value or "" for name, value in attrs}))
        self.ids += [value or "" for name, value in attrs if name == "id"]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in SELF_CLOSING:
            self.errors.append(f"<{tag}/> closes itself")
        self.elements.append((tag, {name: value or "" for name, value in attrs}))

    def handle_endtag(self, tag: str) -> None:
        if not self.open or self.open[-1] != tag:
            self.errors.append(f"</{tag}> where {self.open[-1:]} is open")
        else:
            self.open.pop()

    def handle_data(self, data: str) -> None:
        self.words.append(data)

    @property
    def text(self) -> str:
        """All text, with single spaces."""
        return re.sub(r"\s+", " ", " ".join(self.words))


def typed(document: dict[str, Any]) -> ScorecardDocument:
    """The typed document of these JSON values."""
    return msgspec.convert(document, ScorecardDocument)


def files(document: dict[str, Any], poses: Path | None = None) -> Iterator[tuple[str, str]]:
    """Every file of the site that shows these JSON values, except the pages of tasks, which are many."""
    kinds = tuple(page for page in pages() if page.title != TASK_PAGES)
    return site_files(typed(document), poses, kinds)


def read(document: dict[str, Any]) -> dict[str, Reader]:
    """Every HTML page of the site, by its path."""
    return {path: Reader(text) for path, text in files(document) if path.endswith(".html")}
