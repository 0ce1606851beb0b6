"""Splits the bytes of a CSV file into columns of text."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gym_extensions.rollouts.episodes import SUCCESS

COMMA, LINE_END = b",\n"
BOM = b"\xef\xbb\xbf"
BLOCK_BYTES = 2**20
OPTIONAL = SUCCESS
"""The column whose cells may be empty."""


@dataclass(frozen=True)
class Text:
    """The bytes of a CSV file, its path inside the submission, and the header that it must have."""

    path: str
    header: tuple[str, ...]
    data: bytes


@dataclass(frozen=True)
class Lines:
    """Consecutive lines of a file.

    ``first`` is the index of the first line in the file, from 0; ``starts`` and ``ends`` are offsets in
    ``data`` (an end is after the line end). ``wrong`` marks lines with another number of cells than the
    header, or with an empty cell outside ``OPTIONAL``.
    """

    first: int
    data: bytes
    starts: NDArray[np.intp]
    ends: NDArray[np.intp]
    wrong: NDArray[np.bool_]


def columns(text: Text) -> dict[str, list[str]]:
    """The cells by column. The rules of text must have passed."""
    width = len(text.header)
    cells = text.data[text.data.index(b"\n") + 1 : -1].decode("ascii").replace("\n", ",").split(",")
    return {name: cells[index::width] for index, name in enumerate(text.header)}


def plain(data: bytes) -> bytes:
    r"""The bytes without a byte order mark, with line ends ``\n``."""
    return data.removeprefix(BOM).replace(b"\r\n", b"\n")


def lines(text: Text) -> Iterator[Lines]:
    """All lines of a file in blocks of about ``BLOCK_BYTES``, to bound the memory for files of many lines."""
    data, width, first, start = text.data, len(text.header), 0, 0
    optional = text.header.index(OPTIONAL) if OPTIONAL in text.header else -1
    while start < len(data):
        stop = data.find(b"\n", start + BLOCK_BYTES) + 1 or len(data)
        block = data[start:stop] if data[stop - 1] == LINE_END else data[start:stop] + b"\n"
        values = np.frombuffer(block, dtype=np.uint8)
        cuts = np.flatnonzero((values == COMMA) | (values == LINE_END))
        ending = values[cuts] == LINE_END
        wrong = np.diff(np.flatnonzero(ending), prepend=-1) != width
        empty = np.flatnonzero(np.diff(cuts, prepend=-1) == 1)
        if empty.size:
            rows = (np.cumsum(ending) - ending)[empty]
            columns_before = empty - np.concatenate([[-1], np.flatnonzero(ending)])[rows] - 1
            wrong[rows[columns_before != optional]] = True
        ends = cuts[ending] + 1
        yield Lines(first, block, np.concatenate([[0], ends[:-1]]), ends, wrong)
        first, start = first + ends.size, stop
