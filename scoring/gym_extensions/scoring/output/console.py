"""How scorecards are written on a terminal: literally, in 80 columns, with colour only where it is one."""

from __future__ import annotations

from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

Document = dict[str, Any]
THOUSANDS = 100_000
"""From this return on, the paper's table is told in thousands."""


class _Console(Console):
    def on_broken_pipe(self) -> None:
        """Leaves it to the command what to do when nobody reads on; rich would end the program."""
        raise BrokenPipeError


def console(errors: bool = False) -> Console:
    """Standard output, or the stream for errors; NO_COLOR is honoured.

    Where it is no terminal it has 80 columns and no colour. What is printed is taken literally:
    strangers write titles and name files.
    """
    return _Console(highlight=False, markup=False, emoji=False, stderr=errors)


def number(value: float | None, digits: int = 3) -> str:
    """A number with a fixed count of digits, or a dash."""
    return "–" if value is None else f"{value:.{digits}f}"


def span(score: Document) -> str:
    """An interval, or a dash."""
    return "–" if score["low"] is None else f"{number(score['low'])} to {number(score['high'])}"


def count(number: int, word: str) -> str:
    """``1 run``, ``2 runs``."""
    return f"{number} {word}{'' if number == 1 else 's'}"


def heading(out: Console, title: str, rest: str) -> None:
    """A bold title, and more in its line."""
    out.print(Text.assemble((title, "bold"), rest))


def returns_cell(cell: Document | None) -> str:
    """Mean and deviation of raw returns, in thousands where they would not fit beside each other."""
    if cell is None:
        return "–"
    if max(abs(cell["mean"]), cell["std"]) >= THOUSANDS:
        return f"{cell['mean'] / 1000:.0f}k ± {cell['std'] / 1000:.0f}k"
    return f"{cell['mean']:.0f} ± {cell['std']:.0f}"


def plain_table(*columns: str) -> Table:
    """A table without lines: the first column to the left, the others to the right."""
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for place, column in enumerate(columns):
        table.add_column(column, justify="left" if place == 0 else "right", overflow="fold")
    return table
