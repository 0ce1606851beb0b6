"""What gym-extensions is, why, how it differs from the paper, its licence, and how to cite it."""

from __future__ import annotations

from collections.abc import Iterator

from gym_extensions.catalog.groups import GROUPS
from gym_extensions.catalog.registry import TASKS
from gym_extensions.site.exports.software import software_bibtex
from gym_extensions.site.leaderboard import Leaderboard
from gym_extensions.site.page import File, Page, Render

PATH = "about.html"


def publish(_site: Leaderboard, render: Render) -> Iterator[File]:
    """One page."""
    yield PATH, render("about.html", PATH, tasks=len(TASKS), groups=len(GROUPS), citation=software_bibtex())


PAGE = Page(title="About", order=70, path=PATH, publish=publish, in_footer=True)
