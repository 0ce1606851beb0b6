"""The pages of a board: 50 rows each, and the table of all rows."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from markupsafe import escape

from gym_extensions.site.addresses import board_path
from gym_extensions.site.views.board import Board
from gym_extensions.site.views.board_row import Row

PAGE_ROWS = 50
PAGE_BYTES = 285_000
"""About the largest size of a page of the table of all rows; some 1000 rows."""
ROW_BYTES = 190
"""Size of a row of that table without its names, with five metrics."""


@dataclass(frozen=True)
class BoardPage:
    """One page of a board.

    Args:
        board: the board.
        number: the page, from 1.
        first: the number of its first row, from 1.
        rows: its rows.
        everything: whether it is a page of the table of all rows.
        pages: how many such pages there are.
    """

    board: Board
    number: int
    first: int
    rows: tuple[Row, ...]
    everything: bool
    pages: int

    @property
    def path(self) -> str:
        """Its path."""
        return board_path(self.board.id, self.number, everything=self.everything)

    @property
    def previous(self) -> str:
        """The path of the page before; empty for the first."""
        at = self.number - 1
        return board_path(self.board.id, at, everything=self.everything) if at else ""

    @property
    def next(self) -> str:
        """The path of the page after; empty for the last."""
        at = self.number + 1
        return board_path(self.board.id, at, everything=self.everything) if at <= self.pages else ""

    @property
    def is_interactive(self) -> bool:
        """Whether it shows every row of the board, so that it can be sorted and filtered."""
        return self.pages == 1 and (self.everything or len(self.rows) == len(self.board.rows))

    @property
    def all_rows(self) -> str:
        """The path of the table of all rows; empty where this page has them all."""
        return "" if self.is_interactive else board_path(self.board.id, everything=True)


def board_pages(board: Board) -> Iterator[BoardPage]:
    """Every page of a board; the table of all rows only if they do not fit on one page."""
    parts = [board.rows[at : at + PAGE_ROWS] for at in range(0, len(board.rows), PAGE_ROWS)]
    yield from _pages(board, parts, everything=False)
    if len(parts) > 1:
        yield from _pages(board, _parts(board.rows), everything=True)


def _parts(rows: Sequence[Row]) -> list[Sequence[Row]]:
    """The rows in as few parts as fit on pages."""
    parts: list[Sequence[Row]] = []
    start, size = 0, 0
    for at, row in enumerate(rows):
        size += _bytes(row)
        if size > PAGE_BYTES:
            parts.append(rows[start:at])
            start, size = at, _bytes(row)
    return [*parts, rows[start:]]


def _bytes(row: Row) -> int:
    """About the size of a row in the table of all rows; an escaped character takes up to six bytes."""
    texts = (row.entry.title[:40], row.entry.name, row.entry.name)
    return ROW_BYTES + sum(len(str(escape(text)).encode()) for text in texts)


def _pages(board: Board, parts: Sequence[Sequence[Row]], *, everything: bool) -> Iterator[BoardPage]:
    first = 1
    for number, rows in enumerate(parts, 1):
        yield BoardPage(board, number, first, tuple(rows), everything, len(parts))
        first += len(rows)
