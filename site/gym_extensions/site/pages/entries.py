"""The list of all submissions, refused ones and published tables included."""

from __future__ import annotations

from collections.abc import Iterator

from gym_extensions.site.leaderboard import Leaderboard
from gym_extensions.site.page import File, Page, Render
from gym_extensions.site.tables.entry_list import entry_pages

PATH = "entries.html"


def publish(site: Leaderboard, render: Render) -> Iterator[File]:
    """Pages of 200 submissions each, sorted by status and name."""
    for page in entry_pages(site.entries, site.boards):
        yield page.path, render("entries.html", page.path, page=page)


PAGE = Page(title="Entries", order=12, path=PATH, publish=publish)
