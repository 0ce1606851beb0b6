"""What changed in the data: a page and an Atom feed of decisions and verifications, newest first.

Dates are those of the reviews, so that the same data gives the same bytes.
"""

from collections.abc import Iterator
from dataclasses import dataclass

from gym_extensions.site import paths
from gym_extensions.site.board_views import Leaderboard
from gym_extensions.site.pages.page import File, Render
from gym_extensions.site.text import count, grouped

MOST = 60
"""Changes that the page and the feed show."""


@dataclass(frozen=True, order=True)
class Change:
    """A decision on a submission, or a verification of it, on a day."""

    date: str  # YYYY-MM-DD
    name: str  # of the submission
    kind: str  # "accepted", "verified" or another decision
    text: str
    title: str = ""  # of the submission

    @property
    def path(self) -> str:
        """The page of the submission."""
        return paths.submission_path(self.name)


def changes(site: Leaderboard) -> list[Change]:
    """All decisions and verifications, newest first. Those of a day, a kind and a submission are one."""
    rows = []
    for card in site.submissions:
        found: dict[tuple[str, str], list[str]] = {}
        for decision in card.decisions:
            found.setdefault((decision.date, decision.action), []).append(decision.reason)
        for date, passed in dict.fromkeys((part.date, part.passed) for part in card.verifications):
            parts = [part for part in card.verifications if (part.date, part.passed) == (date, passed)]
            runs, repeated, episodes = (
                sum(getattr(part, name) for part in parts) for name in ("runs", "repeated", "episodes")
            )
            said = f"{count(runs, 'run')}, {grouped(repeated)} of {grouped(episodes)} episodes repeated."
            found[date, "verified" if passed else "not verified"] = [said]
        rows += [
            Change(date, card.name, kind, " ".join(texts), card.title)
            for (date, kind), texts in found.items()
        ]
    return sorted(rows, reverse=True)


def publish(site: Leaderboard, render: Render) -> Iterator[File]:
    """The page and the feed."""
    rows = changes(site)
    yield "changes.html", render("changes.html", "changes.html", changes=rows[:MOST], total=len(rows))
    yield paths.FEED, render("feed.xml", paths.FEED, changes=rows[:MOST])
