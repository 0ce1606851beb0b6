"""The interface of a page module, and the registry of pages."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from gym_extensions.site.leaderboard import Leaderboard

Render = Callable[..., str]
"""``render(template, path, **values) -> str``: fills a template; ``path`` is the path of the page."""


@dataclass(frozen=True)
class Page:
    """A kind of page.

    Args:
        title: its name in the menu.
        order: its position in the menu.
        publish: yields the path and text of each file.
        path: the path that the menu links to; without it the page is not in the menu.
    """

    title: str
    order: int
    publish: Callable[[Leaderboard, Render], Iterator[tuple[str, str]]]
    path: str = ""


def pages() -> tuple[Page, ...]:
    """The ``PAGE`` of every module in ``pages/``, sorted by order and title."""
    folder = importlib.import_module("gym_extensions.site.pages")
    names = sorted(module.name for module in pkgutil.iter_modules(folder.__path__))
    registered: list[Page] = [importlib.import_module(f"{folder.__name__}.{name}").PAGE for name in names]
    return tuple(sorted(registered, key=lambda page: (page.order, page.title)))
