"""The numbers behind every page, as the scorer's own document."""

from __future__ import annotations

from collections.abc import Iterator

from gym_extensions.site.page import Leaderboard, Page, Render

PATH = "scorecards.json"


def publish(site: Leaderboard, render: Render) -> Iterator[tuple[str, str]]:
    """The scorecards and the boards, the very bytes that ``score`` writes for all submissions."""
    yield PATH, site.document.to_json()
    yield "boards.json", site.scored.to_json()


PAGE = Page(title="Data (JSON)", order=30, path=PATH, publish=publish)
