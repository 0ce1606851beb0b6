"""What can still be read of a CSV file in which a rule found a problem: its other rows, each with its number.

So that all problems are told at once, the rules that come later see these rows. A row that was told as
unreadable is told once: no later rule calls it missing.
"""

from __future__ import annotations

from dataclasses import replace
from string import ascii_letters, digits

import numpy as np
from numpy.typing import NDArray

from gym_extensions.rollouts.reading.csv_lines import LINE_END, Lines, Text, columns, lines, plain
from gym_extensions.rollouts.reading.evaluation_log import KINDS, Cells

LEGIBLE = np.isin(np.arange(256), list((ascii_letters + digits + ",./_\n+-").encode()))
KEYS = ("run", "stage", "episode", "seed")
BLANK = {"length": "1", "return": "0.0", "terminated": "false"}
"""What stands in the place of the measured cells where the keys alone are looked at."""


def _legible(block: Lines) -> NDArray[np.bool_]:
    good = ~block.wrong
    odd = np.flatnonzero(~LEGIBLE[np.frombuffer(block.data, dtype=np.uint8)])
    good[np.searchsorted(block.ends, odd, side="right")] = False
    return good


def legible(text: Text) -> Cells | None:
    """The cells of the rows that have all their cells; None where there is none, or another header."""
    whole = Text(text.path, text.header, plain(text.data))
    header = (",".join(text.header) + "\n").encode()
    if not whole.data.startswith(header):
        return None
    kept, numbers = [header], []
    ends = whole.data.count(LINE_END)
    for block in lines(whole):
        good = _legible(block)
        good[: max(0, 1 - block.first)] = False  # the header
        if block.first + good.size > ends:
            good[-1] = False  # half a row, perhaps
        values = np.frombuffer(block.data, dtype=np.uint8)
        kept.append(values[np.repeat(good, block.ends - block.starts)].tobytes())
        numbers.append(np.flatnonzero(good) + block.first - 1)
    rows = np.concatenate(numbers)
    if not rows.size:
        return None
    unread = ends + (not whole.data.endswith(b"\n")) - 1 - rows.size
    return Cells(text.path, columns(replace(whole, data=b"".join(kept))), rows, unread)


def _only(cells: Cells, names: tuple[str, ...]) -> Cells | None:
    """The rows in which the cells of these columns are of their kind; None where there is none."""
    count = len(next(iter(cells.columns.values())))
    checked = [(KINDS[name][0], cells.columns[name]) for name in names if name in cells.columns]
    good = [row for row in range(count) if all(test(column[row]) for test, column in checked)]
    numbers = np.arange(count) if cells.numbers is None else cells.numbers
    taken = {name: [column[row] for row in good] for name, column in cells.columns.items()}
    return Cells(cells.path, taken, numbers[good], cells.unread + count - len(good)) if good else None


def keys_alone(cells: Cells) -> Cells | None:
    """The rows of a log whose keys can be read, with ``BLANK`` for what was measured."""
    found = _only(cells, KEYS)
    if found is None:
        return None
    blank = {name: [cell] * len(found.columns[name]) for name, cell in BLANK.items()}
    return replace(found, columns=found.columns | blank)


def every_cell(cells: Cells) -> Cells | None:
    """The rows in which every cell can be read."""
    return _only(cells, tuple(KINDS))
