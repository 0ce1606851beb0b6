"""The overview: a row per group and budget, and the best answer so far in sentences."""

from __future__ import annotations

from bisect import bisect_right
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate

from markupsafe import escape

from gym_extensions.catalog.suites import SUITES
from gym_extensions.site.text.labels import ends, mean
from gym_extensions.site.text.names import short
from gym_extensions.site.text.numbers import count
from gym_extensions.site.views.board import Board
from gym_extensions.site.views.board_row import Row
from gym_extensions.site.views.entrant import SEQUENTIAL

ROWS_BYTES = 28_000
"""About the largest size of all rows; further boards are on the pages of the groups."""
ROW_BYTES = 700
"""Size of a row without titles and names."""
MAX_REASONS = 6
MAX_TITLE = 40
MAX_NAMED = 3
"""Boards whose first entry a sentence names."""


@dataclass(frozen=True)
class Overview:
    """The boards of sequential training.

    Args:
        rows: boards with a score.
        without_score: boards whose entries have no score.
        more: the number of boards with a score that have no row.
    """

    rows: tuple[Board, ...]
    without_score: tuple[Board, ...]
    more: int

    @property
    def answers(self) -> tuple[str, ...]:
        """Who is best in final performance and who forgets least, in sentences; empty without ranks.

        Where some boards have several ranked entries, the boards of a single one are left out.
        """
        groups = [board for board in self.rows if not board.suite] or list(self.rows)
        compared = [board for board in groups if board.ranked > 1] or groups
        final = [(board, row) for board in compared if (row := board.best)]
        least = [(board, row) for board in compared if (row := board.least_forgetting)]
        return tuple(
            sentence
            for sentence in (
                _answer("Best final performance", final, "final_performance", "leads on"),
                _answer("Least forgetting among those that learned", least, "forgetting", "forgets least on"),
            )
            if sentence
        )


def overview(boards: Sequence[Board]) -> Overview:
    """The overview of all boards, those with a ranked entry first, in the order of ``boards``."""
    sequential = [board for board in boards if board.protocol == SEQUENTIAL]
    scored = sorted((board for board in sequential if board.leader), key=lambda board: board.best is None)
    sizes = list(accumulate(map(_bytes, scored)))
    rows = bisect_right(sizes, ROWS_BYTES)
    return Overview(
        rows=tuple(scored[:rows]),
        without_score=tuple(board for board in sequential if not board.leader),
        more=len(scored) - rows,
    )


def _bytes(board: Board) -> int:
    """About the size of a row; an escaped character takes up to six bytes."""
    rows = (board.best, board.least_forgetting)
    entries = [row.entry for row in rows if row]
    texts = [text for entry in entries for text in (entry.title[:MAX_TITLE], entry.name, entry.name)]
    return ROW_BYTES + sum(len(str(escape(text)).encode()) for text in texts)


def reasons(boards: Sequence[Board]) -> tuple[tuple[str, tuple[Board, ...]], ...]:
    """Boards without a score by the reason, the first reasons; a suite lacks a group's score."""
    by_reason: dict[str, list[Board]] = {}
    for board in boards:
        why = "A suite needs a score in every group." if board.suite else board.why_no_score
        by_reason.setdefault(why, []).append(board)
    return tuple((why, tuple(members)) for why, members in by_reason.items())[:MAX_REASONS]


def _answer(what: str, rows: Sequence[tuple[Board, Row]], metric: str, verb: str) -> str:
    """Who is first on most boards, or who is first on each of the first boards."""
    if not rows:
        return ""
    ((name, wins),) = Counter(row.entry.name for _, row in rows).most_common(1)
    if len(rows) > MAX_NAMED and 2 * wins > len(rows):
        won = [row for _, row in rows if row.entry.name == name]
        ties = sum(row.tied(metric) > 0 for row in won)
        among = f", {ties} of them in a tie" if ties else ""
        boards = count(len(rows), "board")
        ranked = "several ranked entries" if rows[0][0].ranked > 1 else "a ranked entry"
        return f"{what}: {_entry(won[0])} {verb} {wins} of {boards} with {ranked}{among}."
    named = [_first(board, row, metric) for board, row in rows[:MAX_NAMED]]
    if len(rows) > MAX_NAMED:
        named.append(f"{count(len(rows) - MAX_NAMED, 'more board')} below")
    return f"{what}: {'; '.join(named)}."


def _first(board: Board, row: Row, metric: str) -> str:
    """The first entry of a board, its value, and how many entries are tied with it."""
    value = row.trial.metric(metric)
    label = ", task label" if board.task_conditioned else ""
    text = f"{_entry(row)} with {mean(value)} ({ends(value)}) on {_group(board)}, {board.budget}{label}"
    tied = row.tied(metric) if row.ranked else 0
    return f"{text}, a tie of {tied + 1}" if tied else text


def _entry(row: Row) -> str:
    return f"{short(row.entry.title, MAX_TITLE)} ({row.entry.name})"


def _group(board: Board) -> str:
    return f"the suite {board.group}" if board.group in SUITES else board.group
