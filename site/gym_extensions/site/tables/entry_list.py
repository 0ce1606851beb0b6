"""The pages that list all submissions."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from gym_extensions.scoring.scorecard.model import REPORTED, Scorecard
from gym_extensions.site.views.board import Board

PAGE_ROWS = 200
ON_A_BOARD = "On a board"
OFF_BOARDS = "Not on a board: a budget that is only for tests, or no scored group"
PUBLISHED = "Reported elsewhere: published results without logs, shown as printed and not ranked"
REFUSED = "Refused: they break a rule, and are on no board until all problems are fixed"
STATUS = (ON_A_BOARD, OFF_BOARDS, PUBLISHED, REFUSED)


@dataclass(frozen=True)
class EntryPage:
    """A page of the list: submissions under the headings of their status.

    Args:
        number: the page, from 1.
        pages: how many pages there are.
        parts: heading and submissions.
    """

    number: int
    pages: int
    parts: tuple[tuple[str, tuple[Scorecard, ...]], ...]

    @property
    def path(self) -> str:
        """Its path."""
        return list_path(self.number)

    @property
    def previous(self) -> str:
        """The path of the page before; empty for the first."""
        return list_path(self.number - 1) if self.number > 1 else ""

    @property
    def next(self) -> str:
        """The path of the page after; empty for the last."""
        return list_path(self.number + 1) if self.number < self.pages else ""


def list_path(number: int) -> str:
    """The path of a page of the list."""
    return f"entries{f'-{number}' if number > 1 else ''}.html"


def entry_pages(entries: Sequence[Scorecard], boards: Sequence[Board]) -> Iterator[EntryPage]:
    """Every page of the list; one page without submissions."""
    on_boards = {row.entry.name for board in boards for row in board.rows}
    ordered = sorted(entries, key=lambda entry: (STATUS.index(_status(entry, on_boards)), entry.name))
    parts = [ordered[at : at + PAGE_ROWS] for at in range(0, len(ordered), PAGE_ROWS)] or [[]]
    for number, part in enumerate(parts, 1):
        by_status: dict[str, list[Scorecard]] = {}
        for entry in part:
            by_status.setdefault(_status(entry, on_boards), []).append(entry)
        sections = tuple((status, tuple(members)) for status, members in by_status.items())
        yield EntryPage(number, len(parts), sections)


def _status(entry: Scorecard, on_boards: set[str]) -> str:
    if entry.problems:
        return REFUSED
    if entry.trust == REPORTED:
        return PUBLISHED
    return ON_A_BOARD if entry.name in on_boards else OFF_BOARDS
