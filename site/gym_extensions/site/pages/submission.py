"""One page for each submission: what it is, what it scored, and the numbers behind that."""

from __future__ import annotations

from collections.abc import Iterator

from gym_extensions.site.page import Leaderboard, Page, Render


def publish(site: Leaderboard, render: Render) -> Iterator[tuple[str, str]]:
    """A page for every submission, refused ones too: theirs lists the problems."""
    for entry in site.entries:
        path = site.addresses[entry.name]
        yield path, render("submission.html", path, entry=entry)


PAGE = Page(title="Submissions", order=10, publish=publish)
