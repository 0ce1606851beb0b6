"""The data behind every page: the documents of the scorer and their JSON Schemas."""

from __future__ import annotations

from collections.abc import Iterator

from gym_extensions.scoring.output.schema import schema_texts
from gym_extensions.site.leaderboard import Leaderboard
from gym_extensions.site.page import Page, Render

PATH = "scorecards.json"


def publish(site: Leaderboard, render: Render) -> Iterator[tuple[str, str]]:
    """Scorecards and boards, in the bytes that ``score --json`` writes, and ``schemas/``."""
    yield PATH, site.document.to_json()
    yield "boards.json", site.scored.to_json()
    for name, text in schema_texts().items():
        yield f"schemas/{name}", text


PAGE = Page(title="Data (JSON)", order=30, path=PATH, publish=publish)
