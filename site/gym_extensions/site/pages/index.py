"""The leaderboard: every board, and what is on none."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby

from gym_extensions.site.page import Leaderboard, Page, Render

PATH = "index.html"


def publish(site: Leaderboard, render: Render) -> Iterator[tuple[str, str]]:
    """One page: boards by protocol and budget, then refused submissions and those for tests alone."""
    chapters = [
        (key, tuple(boards))
        for key, boards in groupby(
            site.boards, key=lambda board: (board.task_conditioned, board.protocol, board.budget)
        )
    ]
    refused = [entry for entry in site.entries if entry.problems]
    shown = {row.entry.name for board in site.boards for row in board.rows}
    others = [entry for entry in site.entries if not entry.problems and entry.name not in shown]
    reported = [entry for entry in others if entry.trust == "reported"]
    aside = [entry for entry in others if entry.trust != "reported"]
    lists = {"refused": refused, "reported": reported, "aside": aside}
    yield PATH, render("index.html", PATH, chapters=chapters, **lists)


PAGE = Page(title="Leaderboard", order=0, path=PATH, publish=publish)
