"""The pages of a board: 50 rows each, and the table of all rows."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from gym_extensions.site.addresses import board_path
from gym_extensions.site.views.board import Board
from gym_extensions.site.views.board_row import Row

PAGE_ROWS = 50
ALL_ROWS = 1000
"""Rows of a page of the table of all rows, so that a page stays below 300 kB."""
DRAWN = 6
"""Entries whose scores over the sequence are drawn."""


@dataclass(frozen=True)
class BoardPage:
    """One page of a board.

    Args:
        board: the board.
        number: the page, from 1.
        rows: its rows.
        everything: whether it is a page of the table of all rows.
        pages: how many such pages there are.
    """

    board: Board
    number: int
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
    def first(self) -> int:
        """The number of its first row, from 1."""
        return (self.number - 1) * (ALL_ROWS if self.everything else PAGE_ROWS) + 1

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
    yield from _pages(board, PAGE_ROWS, everything=False)
    if len(board.rows) > PAGE_ROWS:
        yield from _pages(board, ALL_ROWS, everything=True)


def _pages(board: Board, size: int, *, everything: bool) -> Iterator[BoardPage]:
    parts: list[Sequence[Row]] = [board.rows[at : at + size] for at in range(0, len(board.rows), size)]
    for number, rows in enumerate(parts, 1):
        yield BoardPage(board, number, tuple(rows), everything, len(parts))
