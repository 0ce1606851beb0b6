"""Reads the good rows of a CSV file with problems, so that the other rules can check them.

All problems are reported at once, and a row that is reported as unreadable is not reported again as missing.
"""

from __future__ import annotations

from dataclasses import replace
from string import ascii_letters, digits

import numpy as np
from numpy.typing import NDArray

from gym_extensions.rollouts.auditing.digests import DIGITS
from gym_extensions.rollouts.reading.csv_lines import LINE_END, Lines, Text, columns, lines, plain
from gym_extensions.rollouts.reading.evaluation_log import KINDS, Cells

ALLOWED = np.isin(np.arange(256), list((ascii_letters + digits + ",./_\n+-").encode()))
KEYS = ("run", "stage", "episode", "seed")
BLANK = {"length": "1", "return": "0.0", "terminated": "false", "success": "", "trace": "0" * DIGITS}
"""Placeholders for measured cells that are not read."""


def _is_readable(block: Lines) -> NDArray[np.bool_]:
    readable = ~block.wrong
    odd = np.flatnonzero(~ALLOWED[np.frombuffer(block.data, dtype=np.uint8)])
    readable[np.searchsorted(block.ends, odd, side="right")] = False
    return readable


def readable_rows(text: Text) -> Cells | None:
    """The cells of the rows that have all their cells. None if no row has, or if the header is wrong."""
    whole = Text(text.path, text.header, plain(text.data))
    header = (",".join(text.header) + "\n").encode()
    if not whole.data.startswith(header):
        return None
    parts, numbers = [header], []
    ends = whole.data.count(LINE_END)
    for block in lines(whole):
        readable = _is_readable(block)
        readable[: max(0, 1 - block.first)] = False  # the header
        if block.first + readable.size > ends:
            readable[-1] = False  # the last row has no line end and may be incomplete
        values = np.frombuffer(block.data, dtype=np.uint8)
        parts.append(values[np.repeat(readable, block.ends - block.starts)].tobytes())
        numbers.append(np.flatnonzero(readable) + block.first - 1)
    rows = np.concatenate(numbers)
    if not rows.size:
        return None
    unread = ends + (not whole.data.endswith(b"\n")) - 1 - rows.size
    return Cells(text.path, columns(replace(whole, data=b"".join(parts))), rows, unread)


def _parsed_rows(cells: Cells, names: tuple[str, ...]) -> Cells | None:
    """The rows in which the cells of these columns are of the right kind, or None if there are none."""
    count = len(next(iter(cells.columns.values())))
    tests = [(KINDS[name][0], cells.columns[name]) for name in names if name in cells.columns]
    rows = [row for row in range(count) if all(test(column[row]) for test, column in tests)]
    if not rows:
        return None
    numbers = np.arange(count) if cells.numbers is None else cells.numbers
    selected = {name: [column[row] for row in rows] for name, column in cells.columns.items()}
    return Cells(cells.path, selected, numbers[rows], cells.unread + count - len(rows))


def key_parsed_rows(cells: Cells) -> Cells | None:
    """The rows of a log whose keys can be parsed, with ``BLANK`` in the measured columns."""
    parsed = _parsed_rows(cells, KEYS)
    if parsed is None:
        return None
    blank = {
        name: [cell] * len(parsed.columns[name]) for name, cell in BLANK.items() if name in parsed.columns
    }
    return replace(parsed, columns=parsed.columns | blank)


def fully_parsed_rows(cells: Cells) -> Cells | None:
    """The rows in which every cell can be parsed."""
    return _parsed_rows(cells, tuple(KINDS))
