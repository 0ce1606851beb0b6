"""The pages of every board: its entries, what they retain of each task, their scores over the sequence."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from gym_extensions.site.charts.strip_plot import board_scale
from gym_extensions.site.leaderboard import Leaderboard
from gym_extensions.site.output import encoded
from gym_extensions.site.page import Draft, File, Page, Render
from gym_extensions.site.tables.board_page import board_pages


def publish(site: Leaderboard, render: Render) -> Iterator[File]:
    """Pages of 50 rows, and the table of all rows where that is not the same."""
    for board in site.boards:
        scale = board_scale(board.trials)
        certainty = board.leader.certainty if board.leader else ""
        counts, first = (len(board.rows), board.ranked), board.rows[0].entry
        shared = (board.id, counts, first, certainty, board.unsolved_tasks, board.reasons, scale)
        for page in board_pages(board):
            template = "rows.html" if page.everything else "board.html"
            rows = [(row.entry, row.entrant.inputs) for row in page.rows]
            write = partial(render, template, page.path, page=page, board=board, scale=scale)
            yield page.path, Draft(encoded((shared, page.pages, rows)), write)


PAGE = Page(title="Boards", order=6, publish=publish)
