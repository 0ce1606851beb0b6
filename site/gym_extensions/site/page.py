"""What a page module provides, and the folder as the registry of pages."""

from __future__ import annotations

import hashlib
import importlib
import pkgutil
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property

from gym_extensions.errors import BenchError
from gym_extensions.scoring.leaderboard.board import boards as scored_boards
from gym_extensions.scoring.leaderboard.model import BoardsDocument
from gym_extensions.scoring.scorecard.model import ReferencesInfo, Scorecard, ScorecardDocument
from gym_extensions.site.views.board import Board, boards


@dataclass(frozen=True)
class Leaderboard:
    """What pages are made from: the scorecards and their boards."""

    document: ScorecardDocument

    @cached_property
    def entries(self) -> tuple[Scorecard, ...]:
        """Every submission, by name."""
        return tuple(sorted(self.document.submissions, key=lambda card: card.name))

    @cached_property
    def references(self) -> ReferencesInfo:
        """The references that normalize all scores."""
        return self.document.references

    @cached_property
    def boards(self) -> tuple[Board, ...]:
        """Every board, in the order of the index."""
        return boards(self.scored.boards, self.entries)

    @cached_property
    def scored(self) -> BoardsDocument:
        """The scorer's boards of all submissions that are not refused."""
        return scored_boards([card for card in self.document.submissions if not card.problems])

    @cached_property
    def addresses(self) -> dict[str, str]:
        """The path of every submission's page, by the submission's name."""
        return addresses([entry.name for entry in self.entries])


Render = Callable[..., str]
"""``render(template, path, **values) -> str``: a template as text; ``path`` is the page's own."""


@dataclass(frozen=True)
class Page:
    """A kind of page: ``publish`` yields (path, text) of each file; with a ``path`` it is in the menu."""

    title: str
    order: int
    publish: Callable[[Leaderboard, Render], Iterator[tuple[str, str]]]
    path: str = ""


def pages() -> tuple[Page, ...]:
    """The ``PAGE`` of every module in ``pages/``, by order and title."""
    folder = importlib.import_module("gym_extensions.site.pages")
    names = sorted(module.name for module in pkgutil.iter_modules(folder.__path__))
    found: list[Page] = [importlib.import_module(f"{folder.__name__}.{name}").PAGE for name in names]
    return tuple(sorted(found, key=lambda page: (page.order, page.title)))


def addresses(names: list[str]) -> dict[str, str]:
    """A path for each name, safe in a file system and a URL, and different even where case is not told apart.

    Raises:
        BenchError: two submissions have one name.
    """
    for name in names:
        if names.count(name) > 1:
            hint = "Rename one of the folders."
            raise BenchError("same-name", f"Two submissions are called {name!r}.", hint=hint)
    found: dict[str, str] = {}
    taken: set[str] = set()
    for name in sorted(names):
        plain = re.sub(r"[^a-z0-9-]+", "-", name.lower()).strip("-")[:80]
        if plain != name or plain in taken:
            plain = f"{plain}-{hashlib.sha256(name.encode()).hexdigest()[:8]}".lstrip("-")
        taken.add(plain)
        found[name] = f"submissions/{plain}.html"
    return found
