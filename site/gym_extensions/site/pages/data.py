"""The numbers behind every page, as the scorer's own document."""

from __future__ import annotations

from collections.abc import Iterator

from gym_extensions.scoring.scorecard import text
from gym_extensions.site.page import Leaderboard, Page, Render

PATH = "scorecards.json"


def publish(site: Leaderboard, render: Render) -> Iterator[tuple[str, str]]:
    """The scorecard document, the very bytes that ``score --json`` prints for all submissions."""
    yield PATH, text(dict(site.document))


PAGE = Page(title="Data (JSON)", order=30, path=PATH, publish=publish)
