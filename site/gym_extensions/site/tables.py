"""The tables of metrics and returns: their cells, and which rows are on which page.

Cells are written here, because a large site has millions of them and a template needs several times as long.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from markupsafe import Markup, escape

from gym_extensions.rollouts.review import REPORTED
from gym_extensions.scoring.metrics import BY_NAME, MetricValue
from gym_extensions.scoring.published import PaperCell
from gym_extensions.scoring.scorecard import ReferenceValue, Scorecard
from gym_extensions.site.api import board_path
from gym_extensions.site.boards import Board, Row
from gym_extensions.site.text import ends, fixed, half_width, rank, tied, variation
from gym_extensions.site.trial import Change, Trial, nothing_to_forget


def spreads(cells: Iterable[PaperCell | None], digits: int) -> Markup:
    """Mean ± standard deviation of each cell, or a dash."""
    return Markup("".join(_spread(cell, digits) for cell in cells))


def _spread(cell: PaperCell | None, digits: int) -> str:
    if cell is None:
        return '<td class="num"><span class="none">–</span></td>'
    mean, deviation = fixed(cell.mean, digits), fixed(cell.std, digits)
    return f'<td class="num">{mean} <span class="ends">± {deviation}</span></td>'


def nothing(trial: Trial) -> Markup:
    """The note beside the forgetting of an agent that learned nothing; else empty."""
    if not trial.learned_nothing:
        return Markup("")
    return Markup('<span class="nothing">{}</span>').format(nothing_to_forget(trial))


def figures(
    trial: Trial, columns: Sequence[str], reasons: Sequence[str], notes: str, row: Row | None = None
) -> Markup:
    """A cell per metric: mean, interval, and on a board the rank.

    Args:
        trial: the scores.
        columns: the names of the metrics.
        reasons: why values are missing, as the notes below the table list them.
        notes: the beginning of the anchor of these notes.
        row: the row of the board; without it, there are no ranks and no values for sorting.
    """
    estimates = (_estimate(trial.metric(name), reasons, notes) for name in columns)
    return Markup(
        "".join(
            _figure(trial, name, estimate, row, is_first=name == columns[0])
            for name, estimate in zip(columns, estimates, strict=True)
        )
    )


def _figure(trial: Trial, name: str, estimate: str, row: Row | None, *, is_first: bool) -> str:
    is_forgetting = name == "forgetting"
    kind = f"num{' first' if is_first else ''}{' muted' if is_forgetting and trial.learned_nothing else ''}"
    return (
        f'<td class="{kind}" data-label="{escape(BY_NAME[name].title)}"'
        f"{_sorted_by(trial.metric(name)) if row else ''}>"
        f"{estimate}{f' {nothing(trial)}' if is_forgetting else ''}"
        f"{_rank(row, name, with_ties=is_first) if row else ''}</td>\n"
    )


def _sorted_by(value: MetricValue) -> str:
    """The attributes that the script of the table reads."""
    half = half_width(value)
    mean = "" if value.mean is None else f' data-v="{value.mean:.4f}"'
    return mean if half is None or not mean else f'{mean} data-h="{half:.4f}"'


def _estimate(value: MetricValue, reasons: Sequence[str], notes: str) -> str:
    if value.mean is None:
        number, why = reasons.index(value.why) + 1, escape(value.why)
        see = f'<a class="see" href="#{notes}-{number}" title="{why}">note {number}</a>'
        return f'<span class="none">– {see}</span>'
    return f'<span class="value">{fixed(value.mean)}</span> <span class="ends">{ends(value)}</span>'


def _rank(row: Row, name: str, *, with_ties: bool) -> str:
    interval = row.shown_rank(name)
    if interval is None:
        return ""
    others = row.tied(name) if with_ties else 0
    versus = row.entry.vs_leader
    level = "; level with the first" if versus and not versus.separated else ""
    ties = f' <span class="tied">{tied(others)}{level}</span>' if others else ""
    return f' <span class="rank">{rank(interval)}</span>{ties}'


STEPS = 10
MAX_CELLS = 3_000
"""Cells of all runs' matrices on one page; those of larger groups are in the data alone."""
CHANGE_STEPS = 5
LARGEST_CHANGE = 1.0
"""The change with the strongest tint: the whole distance from floor to expert."""


def tint(value: float, reference: ReferenceValue | None, top: float = 1.0) -> str:
    """A class of the style sheet: ``h0`` (floor) … ``h10``, ``below`` or ``open``.

    Args:
        value: a raw return.
        reference: floor and expert of the task.
        top: the score with the strongest tint, the highest of the matrix or 1 if that is higher.
    """
    share = reference.normalize(value) if reference else None
    if share is None:
        return "open"
    level = math.floor(share / top * STEPS + 0.5)
    return "below" if level < 0 else f"h{min(level, STEPS)}"


def tinted(rows: Sequence[Sequence[float]], trial: Trial) -> list[list[tuple[str, str]]]:
    """The cells of a matrix ``[row][task]`` of raw returns: tint and text of each."""
    columns = [(trial.reference(task), trial.top_score, trial.matrix_digits) for task in trial.tasks]
    return [
        [
            (tint(value, reference, top), fixed(value, digits))
            for value, (reference, top, digits) in zip(row, columns, strict=True)
        ]
        for row in rows
    ]


def stage_rows(cells: Sequence[Sequence[float]], trial: Trial) -> Markup:
    """The rows of a matrix ``[stage][task]``, each with the task that was trained last; that cell is marked.

    They are written here, because a large site has millions of cells and a template needs longer for each.
    """
    titles = [variation(task, trial.tasks) for task in trial.tasks]
    rows = []
    for stage, row in enumerate(tinted(cells, trial)):
        title = f"{stage} {titles[stage - 1]}" if stage else "no training"
        body = "".join(
            f'<td class="{kind}{" trained" if at == stage else ""}">{text}'
            for at, (kind, text) in enumerate(row, 1)
        )
        rows.append(f'<tr><th scope="row">{title}</th>\n{body}</tr>\n')
    return Markup("".join(rows))


def shows_each_run(trial: Trial) -> bool:
    """Whether the page has the matrix of every run: at most some thousand cells, or it would be too large."""
    return len(trial.runs) * len(trial.tasks) ** 2 <= MAX_CELLS


def change_tint(change: Change) -> str:
    """Classes of the style sheet: ``lost1`` … ``lost5``, ``kept``, ``won1`` … ``won5``.

    It is ``raw`` without an expert. ``unsure`` is added where the interval contains 0 or there is none.
    """
    unsure = "" if change.is_certain else " unsure"
    mean = change.value.mean
    if mean is None or not change.normalized:
        return f"raw{unsure}"
    level = min(CHANGE_STEPS, math.floor(abs(mean) / LARGEST_CHANGE * CHANGE_STEPS + 0.5))
    kind = "kept" if level == 0 else f"{'lost' if mean < 0 else 'won'}{level}"
    return kind + unsure


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


ENTRIES_PER_PAGE = 200
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
    parts = [ordered[at : at + ENTRIES_PER_PAGE] for at in range(0, len(ordered), ENTRIES_PER_PAGE)] or [[]]
    for number, part in enumerate(parts, 1):
        by_status: dict[str, list[Scorecard]] = {}
        for entry in part:
            by_status.setdefault(_status(entry, on_boards), []).append(entry)
        sections = tuple((status, tuple(members)) for status, members in by_status.items())
        yield EntryPage(number, len(parts), sections)


def _status(entry: Scorecard, on_boards: set[str]) -> str:
    if entry.problems:
        return REFUSED
    if entry.level == REPORTED:
        return PUBLISHED
    return ON_A_BOARD if entry.name in on_boards else OFF_BOARDS
