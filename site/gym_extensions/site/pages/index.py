"""The leaderboard: every board, and the submissions that are on none."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby

from gym_extensions.scoring.scorecard.model import REPORTED
from gym_extensions.site.leaderboard import Leaderboard
from gym_extensions.site.page import Page, Render

PATH = "index.html"


def publish(site: Leaderboard, render: Render) -> Iterator[tuple[str, str]]:
    """One page: boards by protocol and budget, then refused, reported and test submissions."""
    chapters = [
        (key, tuple(boards))
        for key, boards in groupby(
            site.boards, key=lambda board: (board.task_conditioned, board.protocol, board.budget)
        )
    ]
    refused = [entry for entry in site.entries if entry.problems]
    on_boards = {row.entry.name for board in site.boards for row in board.rows}
    others = [entry for entry in site.entries if not entry.problems and entry.name not in on_boards]
    reported = [entry for entry in others if entry.trust == REPORTED]
    off_boards = [entry for entry in others if entry.trust != REPORTED]
    lists = {"refused": refused, "reported": reported, "off_boards": off_boards}
    yield PATH, render("index.html", PATH, chapters=chapters, **lists)


PAGE = Page(title="Leaderboard", order=0, path=PATH, publish=publish)
