"""What changed in the data: a page and an Atom feed of decisions and verifications, newest first.

Dates are those of the reviews, so that the same data gives the same bytes.
"""

from collections import Counter
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
        totals: dict[tuple[str, str], Counter[str]] = {}
        for part in card.verifications:
            total = totals.setdefault((part.date, "verified" if part.passed else "not verified"), Counter())
            total.update(runs=part.runs, repeated=part.repeated, episodes=part.episodes)
        for key, total in totals.items():
            text = count(total["runs"], "run")
            if total["episodes"]:
                text += f", {grouped(total['repeated'])} of {grouped(total['episodes'])} episodes repeated"
            found[key] = [f"{text}."]
        for (date, kind), texts in found.items():
            rows.append(Change(date, card.name, kind, " ".join(texts), card.title))
    return sorted(rows, reverse=True)


def publish(site: Leaderboard, render: Render) -> Iterator[File]:
    """The page, on which what is said of several submissions on a day is said once, and the feed."""
    rows, merged = changes(site), dict[tuple[str, str, str], list[Change]]()
    for row in rows[:MOST]:
        merged.setdefault((row.date, row.kind, row.text), []).append(row)
    yield "changes.html", render("changes.html", "changes.html", merged=merged, shown=MOST, total=len(rows))
    yield paths.FEED, render("feed.xml", paths.FEED, changes=rows[:MOST])
