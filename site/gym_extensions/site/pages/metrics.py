"""What every number means: each metric with its formula, and the rules by which boards are read."""

from __future__ import annotations

from collections.abc import Iterator

from gym_extensions.site.page import Leaderboard, Page, Render

PATH = "metrics.html"


def publish(site: Leaderboard, render: Render) -> Iterator[tuple[str, str]]:
    """One page, an anchor for each metric."""
    yield PATH, render("metrics.html", PATH)


PAGE = Page(title="Metrics", order=20, path=PATH, publish=publish)
