"""What changed: entries, releases, and both as an Atom feed."""

from __future__ import annotations

from collections.abc import Iterator

from gym_extensions.site.changes.changelog import folder, releases
from gym_extensions.site.changes.entries import entry_events
from gym_extensions.site.changes.feed import feed
from gym_extensions.site.leaderboard import Leaderboard
from gym_extensions.site.page import File, Page, Render

PATH = "changes.html"
MAX_EVENTS = 100


def publish(site: Leaderboard, render: Render) -> Iterator[File]:
    """The page and the feed."""
    history, events = releases(folder()), entry_events(site.entries)
    yield PATH, render("changes.html", PATH, releases=history, events=events[:MAX_EVENTS], count=len(events))
    yield "feed.xml", feed(history, events)


PAGE = Page(title="Changes", order=65, path=PATH, publish=publish, in_footer=True)
