"""The pages of every board: its entries, what they retain of each task, their scores over the sequence."""

from __future__ import annotations

from collections.abc import Iterator

import msgspec

from gym_extensions.site.leaderboard import Leaderboard
from gym_extensions.site.page import Draft, File, Page, Render
from gym_extensions.site.tables.board_page import BoardPage, board_pages


def publish(site: Leaderboard, render: Render) -> Iterator[File]:
    """Pages of 50 rows, and the table of all rows where that is not the same."""
    for board in site.boards:
        for page in board_pages(board):
            yield page.path, _draft(page, render)


def _draft(page: BoardPage, render: Render) -> Draft:
    template = "rows.html" if page.everything else "board.html"
    return Draft(_inputs(page), lambda: render(template, page.path, page=page, board=page.board))


def _inputs(page: BoardPage) -> bytes:
    """What a page shows: its rows, the number of pages, and the first entry of the board."""
    board = page.board
    certainty = board.leader.certainty if board.leader else ""
    first = board.rows[0].entry
    rows = [(row.entry, row.card, row.trial.score, row.retention) for row in page.rows]
    return msgspec.json.encode(
        (board.id, len(board.rows), page.pages, certainty, board.unsolved_tasks, first, rows)
    )


PAGE = Page(title="Boards", order=6, publish=publish)
