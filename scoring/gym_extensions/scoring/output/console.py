"""Writes literal text, in color on a terminal, and 80 columns wide elsewhere."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Protocol

from rich.console import Console
from rich.table import Table
from rich.text import Text

from gym_extensions.scoring.metrics.paper_table import PaperCell
from gym_extensions.scoring.scorecard.model import GroupScore

THOUSANDS = 100_000
"""From this return on, the paper's table is printed in thousands."""


class HasInterval(Protocol):
    """Anything with the ends of an interval."""

    @property
    def low(self) -> float | None: ...

    @property
    def high(self) -> float | None: ...


class _Console(Console):
    def on_broken_pipe(self) -> None:
        """Raises, so that the command decides what to do when its reader is gone. Rich would exit."""
        raise BrokenPipeError


def console(errors: bool = False) -> Console:
    """Standard output, or standard error. NO_COLOR is honored.

    Titles and file names come from strangers, so markup is off and they are printed literally.
    """
    return _Console(highlight=False, markup=False, emoji=False, stderr=errors)


def number(value: float | None, digits: int = 3) -> str:
    """A number with a fixed count of digits, or a dash."""
    return "–" if value is None else f"{value:.{digits}f}"


def span(value: HasInterval) -> str:
    """An interval, or a dash."""
    return "–" if value.low is None else f"{number(value.low)} to {number(value.high)}"


def count(number: int, word: str) -> str:
    """``1 run``, ``2 runs``."""
    return f"{number} {word}{'' if number == 1 else 's'}"


def heading(out: Console, title: str, rest: str) -> None:
    """A bold title followed by plain text on the same line."""
    out.print(Text.assemble((title, "bold"), rest))


def returns_cell(cell: PaperCell | None) -> str:
    """Mean and deviation of raw returns, in thousands where they would be too wide."""
    if cell is None:
        return "–"
    if max(abs(cell.mean), cell.std) >= THOUSANDS:
        return f"{cell.mean / 1000:.0f}k ± {cell.std / 1000:.0f}k"
    return f"{cell.mean:.0f} ± {cell.std:.0f}"


def table_rows(score: GroupScore) -> Iterator[tuple[str, list[PaperCell | None]]]:
    """The paper's table row by row: task id or name of the total, and the four cells."""
    for row in score.paper_table:
        yield row.task, row.cells()
    for name, total in (("total", score.paper_total), ("printed total", score.printed_total)):
        if total:
            yield name, total.cells()


def plain_table(*columns: str) -> Table:
    """A table without lines, with the first column aligned left and the others right."""
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for index, column in enumerate(columns):
        table.add_column(column, justify="left" if index == 0 else "right", overflow="fold")
    return table
