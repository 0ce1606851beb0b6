"""Reads the built pages: their elements, their text, and the errors in their markup."""

import posixpath
import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import html5lib
import msgspec

from gym_extensions.references import References, load_references
from gym_extensions.scoring.scorecard import ScorecardDocument
from gym_extensions.scoring.submission.scorer import completed
from gym_extensions.site.build import Site
from gym_extensions.site.pages import PAGES
from gym_extensions.site.pages.page import TASK_LIST, Page, Render
from gym_extensions.site.play.assets import Simulator


def beside(path: str, address: str) -> str:
    """The path to which an address of a page leads."""
    return posixpath.normpath(posixpath.join(posixpath.dirname(path), address))


class Reader(HTMLParser):
    """The elements and the text of a page or of a part of one."""

    def __init__(self, markup: str) -> None:
        super().__init__(convert_charrefs=True)
        self.markup = markup
        self.elements: list[tuple[str, dict[str, str]]] = []
        self.words: list[str] = []
        self.feed(markup)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, {name: value or "" for name, value in attrs}))

    def handle_data(self, data: str) -> None:
        self.words.append(data)

    @property
    def ids(self) -> list[str]:
        """The ids of its elements."""
        return [attributes["id"] for _, attributes in self.elements if "id" in attributes]

    def links(self, path: str) -> Iterator[tuple[str, str]]:
        """The files of the site that the page of this path links to or loads, each with the anchor."""
        for _, attributes in self.elements:
            address = urlsplit(attributes.get("href") or attributes.get("src", ""))
            if (address.path or address.fragment) and not address.scheme:
                yield beside(path, address.path) if address.path else path, address.fragment

    @property
    def errors(self) -> list[str]:
        """What the parser of the HTML standard reports, with the position."""
        parser = html5lib.HTMLParser()
        is_page = self.markup.startswith("<!doctype")
        (parser.parse if is_page else parser.parseFragment)(self.markup)
        return [f"{position}: {code} {data}" for position, code, data in parser.errors]

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


def references_of(whole: ScorecardDocument) -> References:
    """The references that a document names: the current ones, or others that are not known."""
    current, named = load_references(), whole.references
    return current if named.sha256 == current.digest else References(named.version, {}, named.sha256)


def site_files(
    document: dict[str, Any],
    kinds: tuple[Page, ...] = PAGES,
    folders: Mapping[str, Path] | None = None,
    docs: bool = False,
    simulator: Simulator | None = None,
) -> Iterator[tuple[str, str]]:
    """Every text file of the site that shows these JSON values; of all kinds of pages, or of some."""
    whole = typed(document)
    site = Site(Render(references_of(whole), kinds, folders or {}, simulator, docs=docs))
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
