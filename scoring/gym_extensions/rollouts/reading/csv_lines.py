"""A log's bytes as columns of text, cut without interpreting them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

COMMA, LINE_END = b",\n"
BOM = b"\xef\xbb\xbf"
BLOCK = 2**20


@dataclass(frozen=True)
class Text:
    """The bytes of one CSV file: its path inside the submission and the header that it must have."""

    path: str
    header: tuple[str, ...]
    data: bytes


@dataclass(frozen=True)
class Lines:
    """Some lines that follow one another.

    The number of the ``first`` from 0, their bytes, where each starts and where it ends (after its line end),
    and whether it is wrong: it has another number of cells than it must, or an empty one.
    """

    first: int
    data: bytes
    starts: NDArray[np.intp]
    ends: NDArray[np.intp]
    wrong: NDArray[np.bool_]


def columns(text: Text) -> dict[str, list[str]]:
    """Each column's cells by its name; only for bytes in which no rule found a problem."""
    width = len(text.header)
    cells = text.data[text.data.index(b"\n") + 1 : -1].decode("ascii").replace("\n", ",").split(",")
    return {name: cells[place::width] for place, name in enumerate(text.header)}


def plain(data: bytes) -> bytes:
    r"""The bytes without a byte order mark, with the line end ``\n``."""
    return data.removeprefix(BOM).replace(b"\r\n", b"\n")


def lines(text: Text) -> Iterator[Lines]:
    """All lines of a file, block by block: a file of many lines never stands in memory line by line."""
    data, width, first, start = text.data, len(text.header), 0, 0
    while start < len(data):
        stop = data.find(b"\n", start + BLOCK) + 1 or len(data)
        block = data[start:stop] if data[stop - 1] == LINE_END else data[start:stop] + b"\n"
        values = np.frombuffer(block, dtype=np.uint8)
        cuts = np.flatnonzero((values == COMMA) | (values == LINE_END))
        ending = values[cuts] == LINE_END
        wrong = np.diff(np.flatnonzero(ending), prepend=-1) != width
        empty = np.diff(cuts, prepend=-1) == 1
        if empty.any():
            wrong[(np.cumsum(ending) - ending)[empty]] = True
        ends = cuts[ending] + 1
        yield Lines(first, block, np.concatenate([[0], ends[:-1]]), ends, wrong)
        first, start = first + ends.size, stop
