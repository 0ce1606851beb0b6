"""Rules about the bytes of a log, before a cell is read."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from string import ascii_letters, digits

import numpy as np

from gym_extensions.catalog.task import NAMESPACE
from gym_extensions.errors import did_you_mean
from gym_extensions.rollouts.problem import LONGEST_QUOTE, ROWS_TOLD, Finding, told
from gym_extensions.rollouts.reading.csv_lines import BOM, Text, lines
from gym_extensions.rollouts.rules.rule import rule

EVEN = (ascii_letters + digits + ",./\n\r+-").encode()
REWRITE = "Write it with gym_extensions.rollouts.episodes.write_episodes or write_curves."


@rule("text")
def empty_file(text: Text) -> Iterator[Finding]:
    """A log has a header and at least one row."""
    if text.data.count(b"\n") + (not text.data.endswith(b"\n")) < 2 or not text.data.strip():
        what = "The file is empty." if not text.data.strip() else "The file has a header and no row."
        yield Finding(text.path, what, "Add the rows, or remove the file.")


@rule("text")
def byte_order_mark(text: Text) -> Iterator[Finding]:
    """A log begins with its header, not with a byte order mark."""
    if text.data.startswith(BOM):
        yield Finding(
            text.path, "The file begins with a byte order mark (EF BB BF).", "Save it as UTF-8 without BOM."
        )


@rule("text")
def line_ends(text: Text) -> Iterator[Finding]:
    r"""Lines of a log end with \n alone."""
    count = text.data.count(b"\r")
    if count:
        found = f"The file has {count} carriage return{'s' if count > 1 else ''} (\\r)."
        yield Finding(text.path, found, r"Save it with \n line ends.")


@rule("text")
def truncated_file(text: Text) -> Iterator[Finding]:
    """A log ends with a line end: without one its last row may be half a row."""
    if text.data.strip() and not text.data.endswith((b"\n", b"\r")):
        row = text.data.count(b"\n") + 1
        last = text.data[text.data.rfind(b"\n") + 1 :][:80].decode("ascii", "backslashreplace")
        found = f"The last line, {last!r}, has no line end."
        yield Finding(f"{text.path}, row {row}", found, "The file is cut off: copy or write it again.")


@rule("text")
def wrong_header(text: Text) -> Iterator[Finding]:
    """The first line names the columns that docs/rollout-log.md names, in that order."""
    line = text.data.removeprefix(BOM).split(b"\n", 1)[0].rstrip(b"\r")
    first = line[:2000].decode("utf-8", "backslashreplace")
    names = first.split(",")
    if text.data.strip() and tuple(names) != text.header:
        odd = next((name for name in names if name not in text.header), "")
        close = did_you_mean(odd[:LONGEST_QUOTE], text.header)
        close = close if close.startswith("Did") else ""
        hint = f"Write {','.join(text.header)}. {close}".rstrip()
        yield Finding(f"{text.path}, row 1", f"The header is {first[:200]!r}.", hint)


@rule("text")
def odd_character(text: Text) -> Iterator[Finding]:
    """A log holds letters, digits and , . / + - alone (and the namespace): no quotes, no spaces, no tabs."""
    rest = text.data.removeprefix(BOM).replace(f"{NAMESPACE}/".encode(), b"")
    if not rest.translate(None, EVEN):
        return
    first: dict[int, str] = {}
    count = 0
    for block in lines(replace(text, data=rest)):
        odd = np.flatnonzero(~np.isin(np.frombuffer(block.data, dtype=np.uint8), list(EVEN)))
        rows, places = np.unique(np.searchsorted(block.ends, odd, side="right"), return_index=True)
        count += rows.size
        for row, place in list(zip(rows, odd[places], strict=True))[: ROWS_TOLD - len(first)]:
            first[block.first + int(row) - 1] = chr(block.data[place])
    yield from told(
        text.path,
        list(first),
        lambda row: f"The row holds the character {first[row]!r}.",
        REWRITE,
        more=count - len(first),
    )


@rule("text")
def cell_count(text: Text) -> Iterator[Finding]:
    """Every row has as many cells as the header, and none is empty."""
    first: dict[int, str] = {}
    count = 0
    for block in lines(text):
        found = np.flatnonzero(block.wrong)
        found = found[found + block.first > 0]
        count += found.size
        for at in found[: ROWS_TOLD - len(first)].tolist():
            row = block.data[block.starts[at] : block.ends[at] - 1]
            first[block.first + at - 1] = row.decode("utf-8", "backslashreplace")

    def say(index: int) -> str:
        commas = first[index].count(",")
        if commas != len(text.header) - 1:
            return f"The row has {commas + 1} cells; {len(text.header)} are needed."
        return f"The cell {text.header[first[index].split(',').index('')]!r} is empty."

    hint = "Write every cell of every row."
    yield from told(text.path, list(first), say, hint, more=count - len(first))
