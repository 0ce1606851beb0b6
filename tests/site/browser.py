"""Reads the built pages as a browser does, and records errors in their markup."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import msgspec

from gym_extensions.scoring.scorecard import ScorecardDocument
from gym_extensions.scoring.submission.scorer import completed
from gym_extensions.site.build import Site
from gym_extensions.site.pages import PAGES
from gym_extensions.site.pages.page import TASK_LIST, Page, Render

VOID = {"meta", "link", "br", "col", "wbr", "img", "input", "hr"}
SELF_CLOSING = {"line", "circle", "polygon", "polyline", "rect", "path"}
CELLS = {"td", "th"}
"""Their end tags, and those of rows, may be left out in HTML."""


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
        if tag in CELLS:
            self._close(CELLS)
        if tag == "tr":
            self._close(CELLS)
            self._close({"tr"})
        if tag not in VOID:
            self.open.append(tag)

    def _close(self, tags: set[str]) -> None:
        if self.open and self.open[-1] in tags:
            self.open.pop()

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in SELF_CLOSING:
            self.errors.append(f"<{tag}/> closes itself")
        self.elements.append((tag, {name: value or "" for name, value in attrs}))

    def handle_endtag(self, tag: str) -> None:
        if tag in {"tr", "tbody"} and tag in self.open:
            self._close(CELLS)
        if tag == "tbody":
            self._close({"tr"})
        if not self.open or self.open[-1] != tag:
            self.errors.append(f"</{tag}> where {self.open[-1:]} is open")
        else:
            self.open.pop()

    def handle_data(self, data: str) -> None:
        self.words.append(data)

    @property
    def policy(self) -> str:
        """Its Content-Security-Policy."""
        metas = [attributes for tag, attributes in self.elements if tag == "meta"]
        return next(a["content"] for a in metas if a.get("http-equiv") == "Content-Security-Policy")

    @property
    def text(self) -> str:
        """All text, with single spaces."""
        return re.sub(r"\s+", " ", " ".join(self.words))


def typed(document: dict[str, Any]) -> ScorecardDocument:
    """The typed document of these JSON values, with what follows from them."""
    made = msgspec.convert(document, ScorecardDocument)
    return replace(made, submissions=tuple(map(completed, made.submissions)))


def site_files(
    document: dict[str, Any],
    kinds: tuple[Page, ...] = PAGES,
    folders: Mapping[str, Path] | None = None,
    docs: bool = False,
) -> Iterator[tuple[str, str]]:
    """Every text file of the site that shows these JSON values; of all kinds of pages, or of some."""
    whole = typed(document)
    site = Site(Render(whole.references, kinds, folders or {}, docs=docs))
    for path, content in site.files(whole.submissions):
        if isinstance(content, str):
            yield path, content
        elif path.startswith("static/"):
            yield path, content.decode()


def files(document: dict[str, Any], **folders: Path) -> Iterator[tuple[str, str]]:
    """Every file of the site that shows these JSON values, except the pages of tasks, which are many."""
    kinds = tuple(page for page in PAGES if page.path != TASK_LIST)
    return site_files(document, kinds, folders)


class Pages(Mapping[str, Reader]):
    """The HTML pages of a site by path, each read when it is needed."""

    def __init__(self, texts: dict[str, str]) -> None:
        self._texts = texts
        self._pages: dict[str, Reader] = {}

    def __getitem__(self, path: str) -> Reader:
        if path not in self._pages:
            self._pages[path] = Reader(self._texts[path])
        return self._pages[path]

    def __iter__(self) -> Iterator[str]:
        return iter(self._texts)

    def __len__(self) -> int:
        return len(self._texts)


def read(document: dict[str, Any]) -> Pages:
    """Every HTML page of the site, by its path."""
    return Pages({path: text for path, text in files(document) if path.endswith(".html")})
