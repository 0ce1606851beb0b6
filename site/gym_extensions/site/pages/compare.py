"""The page Compare, and the data that it loads: as scripts, because a page in a file cannot read JSON."""

from __future__ import annotations

import json
from collections.abc import Iterator

from gym_extensions.scoring.ranking.boards import Difference
from gym_extensions.site import paths
from gym_extensions.site.board_views import BoardView, Leaderboard
from gym_extensions.site.pages.page import File, Render

MOST_BOARDS = 40
"""Boards that the page links to."""


def publish(site: Leaderboard, render: Render) -> Iterator[File]:
    """Two menus of entries and what separates them; without script, links to the boards."""
    boards = [board for board in site.boards if board.leader and len(board.rows) > 1]
    yield "compare.html", render("compare.html", "compare.html", boards=boards[:MOST_BOARDS])
    yield paths.COMPARED, index(site)
    for board in site.boards:
        yield paths.board_data(board.id, "pairs.js"), differences(board)


def index(site: Leaderboard) -> str:
    """The script with the entries, the boards that they are on, and the pairs of the core."""
    boards = [
        {
            "group": board.group,
            "label": f"{board.protocol}, {board.budget}{', task label' if board.task_conditioned else ''}",
            "page": paths.board_tab(board.group, board.id),
            "pairs": paths.board_data(board.id, "pairs.js"),
            "id": board.id,
            "entries": [row.entry.name for row in board.rows],
        }
        for board in site.boards
        if len(board.rows) > 1
    ]
    board = site.scored.core
    pairs = {
        metric: [[p.first, p.second, p.mean, p.low, p.high, p.p_value, p.verdict, p.look] for p in found]
        for metric, found in (board.pairs if board else {}).items()
    }
    names = {name for each in boards for name in each["entries"]}
    titles = {entry.name: entry.title for entry in site.entries if entry.name in names}
    groups = {
        entry.name: {group: [value.mean, value.low, value.high] for group, value in entry.groups.items()}
        for entry in (board.rows if board else ())
    }
    document = {"titles": titles, "boards": boards, "core": pairs, "groups": groups}
    return f"compareIndex({json.dumps(document, separators=(',', ':'))});\n"


def differences(board: BoardView) -> str:
    """The script with the differences of the entries of a board, which is loaded when two are compared.

    By the positions i < j of two entries in ``names``: mean, ends of the interval and p value per column.
    """
    known = {name for pair in board.scored.pairs for name in (pair.first, pair.second)}
    names = [row.entry.name for row in board.rows if row.entry.name in known]
    place = {name: at for at, name in enumerate(names)}
    found = {
        f"{place[pair.first]},{place[pair.second]}": [
            _numbers(pair.metrics.get(name)) for name in board.columns
        ]
        for pair in board.scored.pairs
    }
    document = {"board": board.id, "columns": board.columns, "names": names, "pairs": found}
    return f"boardPairs({json.dumps(document, separators=(',', ':'))});\n"


def _numbers(difference: Difference | None) -> list[float | None] | None:
    """Mean, ends of the interval and p value with the digits that pages show, and two more."""
    if difference is None:
        return None
    numbers = (difference.mean, difference.low, difference.high, difference.p_value)
    return [None if number is None else float(f"{number:.4g}") for number in numbers]
