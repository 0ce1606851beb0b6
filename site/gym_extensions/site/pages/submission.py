"""One page per submission: its facts, scores and returns."""

from __future__ import annotations

from collections.abc import Iterator

from gym_extensions.site.leaderboard import Leaderboard
from gym_extensions.site.page import Page, Render


def publish(site: Leaderboard, render: Render) -> Iterator[tuple[str, str]]:
    """A page per submission; that of a refused one lists its problems."""
    for entry in site.entries:
        path = site.addresses[entry.name]
        yield path, render("submission.html", path, entry=entry)


PAGE = Page(title="Submissions", order=10, publish=publish)
