"""The overview: who ends best and who forgets least, per group and budget."""

from __future__ import annotations

from collections.abc import Iterator

from gym_extensions.scoring.scorecard.model import REPORTED
from gym_extensions.site.leaderboard import Leaderboard
from gym_extensions.site.page import File, Page, Render
from gym_extensions.site.text.labels import VERIFIED, level
from gym_extensions.site.views.overview import overview, reasons

PATH = "index.html"


def publish(site: Leaderboard, render: Render) -> Iterator[File]:
    """One page."""
    view = overview(site.boards)
    scored = [entry for entry in site.entries if not entry.problems and entry.trust != REPORTED]
    numbers = {
        "entries": len(scored),
        "verified": sum(level(entry) in VERIFIED for entry in scored),
        "reported": sum(entry.trust == REPORTED for entry in site.entries),
        "refused": sum(bool(entry.problems) for entry in site.entries),
    }
    yield PATH, render("index.html", PATH, view=view, reasons=reasons(view.without_score), **numbers)


PAGE = Page(title="Overview", order=0, path=PATH, publish=publish)
