"""How two entries are compared: on the page of a board, or with ``score --compare``."""

from __future__ import annotations

from collections.abc import Iterator

from gym_extensions.site.leaderboard import Leaderboard
from gym_extensions.site.page import File, Page, Render
from gym_extensions.site.tables.board_page import PAGE_ROWS

PATH = "compare.html"
MAX_BOARDS = 40


def publish(site: Leaderboard, render: Render) -> Iterator[File]:
    """One page, with a link per board that opens it with its first two entries side by side."""
    boards = [board for board in site.boards if board.leader and len(board.rows) > 1]
    yield PATH, render("compare.html", PATH, boards=boards[:MAX_BOARDS], page_rows=PAGE_ROWS)


PAGE = Page(title="Compare", order=15, path=PATH, publish=publish)
