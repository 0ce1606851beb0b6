"""The numbers behind every page, as the scorer's own document."""

from __future__ import annotations

from collections.abc import Iterator

from gym_extensions.scoring.pipeline.score import text
from gym_extensions.site.page import Leaderboard, Page, Render

PATH = "scorecards.json"


def publish(site: Leaderboard, render: Render) -> Iterator[tuple[str, str]]:
    """The scorecards and the boards, the very bytes that ``score`` writes for all submissions."""
    yield PATH, text(dict(site.document))
    yield "boards.json", text({"format": 1, "boards": site.scored})


PAGE = Page(title="Data (JSON)", order=30, path=PATH, publish=publish)
