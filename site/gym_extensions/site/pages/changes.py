"""What changed in the data: a page and an Atom feed of decisions and verifications, newest first.

The page also has the best core score over time. Dates are those of the reviews, so that the same data gives
the same bytes.
"""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from operator import attrgetter

from gym_extensions.scoring.ranking.boards import CoreRow
from gym_extensions.site import paths
from gym_extensions.site.board_views import Leaderboard
from gym_extensions.site.charts import line_charts
from gym_extensions.site.pages import core, overview
from gym_extensions.site.pages.page import File, Render
from gym_extensions.site.submission_results import SEQUENTIAL
from gym_extensions.site.text import count, grouped, mean, split_version
from gym_extensions.submissions.review import TRAINED_HERE

MOST = 60
"""Changes that the feed has."""


@dataclass(frozen=True, order=True)
class Change:
    """What happened to a submission on a day: a decision, a verification, the highest core score."""

    date: str  # YYYY-MM-DD
    name: str  # of the submission
    kind: str  # "accepted", "verified", "highest core score", …
    text: str
    title: str = ""  # of the submission


def changes(site: Leaderboard) -> list[Change]:
    """All decisions, verifications and records, newest first. Those of a day, kind and submission are one."""
    rows = []
    for card in site.submissions:
        found: dict[tuple[str, str], list[str]] = {}
        for decision in card.decisions:
            found.setdefault((decision.date, decision.action), []).append(decision.reason)
        totals: dict[tuple[str, str], Counter[str]] = {}
        for part in card.verifications:
            kind = "verified" if part.passed else "undecided" if part.undecided else "not verified"
            total = totals.setdefault((part.date, kind), Counter())
            total.update(runs=part.runs, repeated=part.repeated, episodes=part.episodes)
        for key, total in totals.items():
            text = count(total["runs"], "run")
            if total["episodes"]:
                text += f", {grouped(total['repeated'])} of {grouped(total['episodes'])} episodes repeated"
            found[key] = [f"{text}."]
        if card.training and (day := card.training.finished):
            found.setdefault((day, TRAINED_HERE), []).append("The project trained its code.")
        for (date, kind), texts in found.items():
            rows.append(Change(date, card.name, kind, " ".join(texts), card.title))
    for title, steps in records(site).items():
        for day, row in steps:
            said = f"{mean(row.metrics[core.FINAL])} by today's runs, {title.lower()}."
            rows.append(Change(day, row.name, "highest core score", said, row.title))
    return sorted(rows, reverse=True)


def records(site: Leaderboard) -> dict[str, list[tuple[str, CoreRow]]]:
    """By list of the core, the methods whose score was above those of all before them, oldest first.

    A method counts from the day on which every group of the core had a verified run of it, or on which its
    runs here were finished. Scores are those of today: nothing states those of a day that has passed.
    """
    cards, found = {card.name: card for card in site.submissions}, dict[str, list[tuple[str, CoreRow]]]()
    for each in site.scored.core.lists if site.scored.core else ():
        best = found.setdefault(overview.LISTS[each.task_conditioned][0], [])
        for row in filter(attrgetter("ranked"), each.rows):  # best first
            card, logs = cards[row.name], [f"{split_version(group)[0]}/{SEQUENTIAL}" for group in row.groups]
            passed = [part for part in card.verifications if part.passed]
            days = [min((part.date for part in passed if log in part.logs), default="") for log in logs]
            day = card.training.finished if row.trained_here and card.training else all(days) and max(days)
            if day and (not best or day < best[0][0]):
                best.insert(0, (day, row))
    return {title: best for title, best in found.items() if best}


def publish(site: Leaderboard, render: Render) -> Iterator[File]:
    """The page, on which what is said of several submissions on a day is said once, and the feed."""
    rows, merged = changes(site), dict[tuple[str, str, str], list[Change]]()
    for row in rows:
        merged.setdefault((row.date, row.kind, row.text), []).append(row)
    best = records(site)
    is_drawn = len({day for steps in best.values() for day, _ in steps}) > 1
    drawing = line_charts.records(best, rows[0].date) if is_drawn else ""
    values = {"merged": merged, "best": best, "drawing": drawing}
    yield "changes.html", render("changes.html", "changes.html", **values)
    yield paths.FEED, render("feed.xml", paths.FEED, changes=rows[:MOST])
