"""The definition of every number: metrics with their formulas, intervals, ranks and budgets."""

from __future__ import annotations

from collections.abc import Iterator

from gym_extensions.site.leaderboard import Leaderboard
from gym_extensions.site.page import File, Page, Render
from gym_extensions.site.views import example

PATH = "metrics.html"


def publish(site: Leaderboard, render: Render) -> Iterator[File]:
    """One page with an anchor per metric."""
    used = {board.budget for board in site.boards}
    yield (
        PATH,
        render(
            "metrics.html", PATH, used_budgets=used, example=example, example_values=example.example_values()
        ),
    )


PAGE = Page(title="Metrics", order=20, path=PATH, publish=publish)
