"""The interface of a page module, and the registry of pages."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Protocol

from gym_extensions.scoring.scorecard.model import Scorecard
from gym_extensions.site.leaderboard import Frame, Leaderboard


class Render(Protocol):
    """Fills a template; ``path`` is the path of the page."""

    @property
    def site(self) -> Frame:
        """What every page shows."""

    @property
    def inputs(self) -> bytes:
        """The digest of the scorecard of the entry whose pages are written; empty for shared pages."""

    def __call__(self, template: str, path: str, **values: object) -> str:
        """The text of the page."""


@dataclass(frozen=True)
class Draft:
    """A file that is written only if its inputs changed.

    Args:
        inputs: everything that the text depends on besides the code, the menu and the references.
        write: returns the text.
    """

    inputs: bytes
    write: Callable[[], str]


File = tuple[str, str | bytes | Draft]
"""A path and its content."""


def no_files(_site: Leaderboard, _render: Render) -> Iterator[File]:
    """No file."""
    return iter(())


def no_entry_files(_entry: Scorecard, _render: Render) -> Iterator[File]:
    """No file per entry."""
    return iter(())


@dataclass(frozen=True)
class Page:
    """A kind of page.

    Args:
        title: its name in the menu.
        order: its position in the menu.
        publish: yields the files that are made from all entries. It gets entries without logs, so that many
            fit in memory.
        path: the path that the menu links to; without it the page is not in the menu.
        in_footer: whether the footer links to it instead of the menu.
        publish_entry: yields the files of one entry, from its whole scorecard.
    """

    title: str
    order: int
    publish: Callable[[Leaderboard, Render], Iterator[File]] = no_files
    path: str = ""
    in_footer: bool = False
    publish_entry: Callable[[Scorecard, Render], Iterator[File]] = no_entry_files


def pages() -> tuple[Page, ...]:
    """The ``PAGE`` of every module in ``pages/`` and its folders, sorted by order and title."""
    folder = importlib.import_module("gym_extensions.site.pages")
    modules = pkgutil.walk_packages(folder.__path__, f"{folder.__name__}.")
    names = sorted(module.name for module in modules if not module.ispkg)
    registered: list[Page] = [importlib.import_module(name).PAGE for name in names]
    return tuple(sorted(registered, key=lambda page: (page.order, page.title)))
