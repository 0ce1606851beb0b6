"""The page Compare, and the data that it loads: as scripts, because a page in a file cannot read JSON."""

import json
from collections.abc import Iterator, Sequence

from gym_extensions.catalog.protocol import STANDARD_BUDGET
from gym_extensions.scoring.ranking.group_board import MAX_PAIRED, pairs_across
from gym_extensions.scoring.scorecard import Scorecard
from gym_extensions.site import board_views, paths, text
from gym_extensions.site.pages.core import EXPLORATORY
from gym_extensions.site.pages.page import File, Render


def publish(site: board_views.Leaderboard, render: Render) -> Iterator[File]:
    """Menus of submissions, and what separates them."""
    is_any = any(board.leader and len(board.rows) > 1 for board in site.boards)
    yield "compare.html", render("compare.html", "compare.html", is_any=is_any)
    yield paths.COMPARED, index(site, render)
    for merged in comparable(site.boards):
        yield paths.board_data(merged[0].id, "pairs.js"), differences(merged, site.submissions)


def comparable(boards: Sequence[board_views.BoardView]) -> list[list[board_views.BoardView]]:
    """The boards of each group, protocol and budget: without and with the task label, or one of them."""
    found: dict[tuple[object, ...], list[board_views.BoardView]] = {}
    for board in boards:  # the score of a suite has no value per run, with which to compare two boards
        is_apart = board.suite and board.task_conditioned
        found.setdefault((board.group, board.protocol, board.budget, is_apart), []).append(board)
    return list(found.values())


def index(site: board_views.Leaderboard, render: Render) -> str:
    """The script with the submissions, their groups in common, the pairs of the core, and their networks."""
    merged = [
        {
            "group": text.group_name(board.group),
            "label": f"{text.PROTOCOLS[board.protocol][0]}, {board.budget}",
            "page": paths.board_tab(board.group, board.id),
            "pairs": paths.board_data(board.id, "pairs.js"),
            "id": board.id,
            "submissions": {
                row.submission.name: row.submission.runs for each in (board, *others) for row in each.rows
            },
        }
        for board, *others in comparable(site.boards)
    ]
    board = site.scored.core
    remark = EXPLORATORY[board.edition] if board else ""
    pairs = {
        metric: [
            [
                *(pair.first, pair.second, pair.mean, pair.low, pair.high),
                *(text.p_equals(pair.p_value), pair.verdict, pair.look, pair.exploratory and remark),
            ]
            for pair in found
        ]
        for metric, found in (board.pairs if board else {}).items()
    }
    titles = {row.submission.name: row.submission.title for each in site.boards for row in each.rows}
    whys = {row.name: row.why for row in (board.rows if board else ())}
    unranked = {
        name: why
        for name in titles
        if (why := whys.get(name, f"No sequential runs of {STANDARD_BUDGET} steps per task."))
    }
    networks = {
        name: {
            text.group_name(group): [
                [round(each.first, 2), round(each.last, 2)] for each in measures.values()
            ]
            for group, measures in groups.items()
        }
        for name, groups in render.networks.items()
        if name in titles
    }
    document = {"titles": titles, "boards": merged, "core": pairs, "unranked": unranked, "networks": networks}
    return f"compareIndex({json.dumps(document, separators=(',', ':'))});\n"


def differences(boards: Sequence[board_views.BoardView], cards: Sequence[Scorecard]) -> str:
    """The script with the differences of the submissions of ``comparable``, loaded when two are compared.

    By the positions i < j of two submissions in ``names``: mean and ends of the interval per column.
    """
    board = boards[0]
    names = [row.submission.name for each in boards for row in each.rows[:MAX_PAIRED]]
    place = {name: at for at, name in enumerate(names)}
    pairs = [pair for each in boards for pair in each.scored.pairs]
    if len(boards) > 1:
        by_name = {card.name: card for card in cards}
        pairs += pairs_across(boards[0].scored, boards[1].scored, by_name)
    found: dict[str, list[list[float | None] | None]] = {}
    for pair in pairs:
        shown = found.setdefault(f"{place[pair.first]},{place[pair.second]}", [])
        for each in map(pair.metrics.get, board.columns):
            # With the digits that pages show, and two more.
            numbers = (each.mean, each.low, each.high) if each else ()
            rounded = [None if number is None else float(f"{number:.4g}") for number in numbers]
            shown.append(rounded or None)
    document = {"board": board.id, "columns": board.columns, "names": names, "pairs": found}
    return f"boardPairs({json.dumps(document, separators=(',', ':'))});\n"
