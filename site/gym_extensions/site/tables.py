"""The tables of returns: their cells and tints, and which rows of long lists are on which page."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from markupsafe import Markup

from gym_extensions.rollouts.review import REPORTED
from gym_extensions.scoring.scorecard import ReferenceValue, Scorecard
from gym_extensions.site.boards import Board
from gym_extensions.site.text import fixed, variation
from gym_extensions.site.trial import Change, Trial

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


SHOWN_ROWS = 20
"""Rows of a board on the page of its group, with drawings; all are in the board's own table."""
PAGE_ROWS = 1000
"""Rows of a page of that table, of at most 300 bytes each."""


@dataclass(frozen=True)
class Part:
    """A page of a list that is too long for one.

    Args:
        rows: what it lists.
        number: the page, from 1.
        pages: how many pages there are.
        path: the path of the page of a number.
    """

    rows: Sequence[Any]
    number: int
    pages: int
    path: Callable[[int], str]


def parts(rows: Sequence[Any], size: int, path: Callable[[int], str]) -> Iterator[Part]:
    """The pages of a list, with ``size`` rows each; one page of an empty list."""
    starts = range(0, max(len(rows), 1), size)
    for number, start in enumerate(starts, 1):
        yield Part(rows[start : start + size], number, len(starts), path)


ENTRIES_PER_PAGE = 200
ON_A_BOARD = "On a board"
OFF_BOARDS = "Not on a board: a budget that is only for tests, or no scored group"
PUBLISHED = "Reported elsewhere: published results without logs, shown as printed and not ranked"
REFUSED = "Refused: they break a rule, and are on no board until all problems are fixed"
STATUS = (ON_A_BOARD, OFF_BOARDS, PUBLISHED, REFUSED)


def list_path(number: int) -> str:
    """The path of a page of the list of all entries."""
    return f"entries{f'-{number}' if number > 1 else ''}.html"


def entry_pages(entries: Sequence[Scorecard], boards: Sequence[Board]) -> Iterator[Part]:
    """Every page of the list: pairs of a status and an entry, sorted by status and name."""
    on_boards = {row.entry.name for board in boards for row in board.rows}
    pairs = [(_status(entry, on_boards), entry) for entry in entries]
    pairs.sort(key=lambda pair: (STATUS.index(pair[0]), pair[1].name))
    return parts(pairs, ENTRIES_PER_PAGE, list_path)


def _status(entry: Scorecard, on_boards: set[str]) -> str:
    if entry.problems:
        return REFUSED
    if entry.level == REPORTED:
        return PUBLISHED
    return ON_A_BOARD if entry.name in on_boards else OFF_BOARDS
