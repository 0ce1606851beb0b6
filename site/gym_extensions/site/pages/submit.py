"""How to submit results, in short; docs/submit.md has the details."""

from __future__ import annotations

from collections.abc import Iterator

from gym_extensions.catalog.budgets import BUDGETS
from gym_extensions.catalog.protocol import FULL_ENTRY_RUNS
from gym_extensions.site.leaderboard import Leaderboard
from gym_extensions.site.page import File, Page, Render

PATH = "submit.html"


def publish(_site: Leaderboard, render: Render) -> Iterator[File]:
    """One page."""
    on_boards = [budget.name for budget in BUDGETS.values() if budget.on_boards]
    yield PATH, render("submit.html", PATH, budgets=on_boards, runs=FULL_ENTRY_RUNS)


PAGE = Page(title="Submit", order=25, path=PATH, publish=publish)
