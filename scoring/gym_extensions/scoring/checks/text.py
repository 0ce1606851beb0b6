"""Rules about the bytes of a log, before a cell is read."""

from __future__ import annotations

import re
from collections.abc import Iterator
from string import ascii_letters, digits

import numpy as np

from gym_extensions.catalog.errors import did_you_mean
from gym_extensions.catalog.tasks import NAMESPACE
from gym_extensions.scoring.checks.rule import rule
from gym_extensions.scoring.problems import Finding, told
from gym_extensions.scoring.text import Text

COMMA, LINE_END = b",\n"
BOM = b"\xef\xbb\xbf"
ODD = re.compile(rb"[^0-9A-Za-z,./\n\r+-]")
EVEN = (ascii_letters + digits + ",./\n\r+-").encode()
REWRITE = "Write it with gym_extensions.scoring.log.write_episodes or write_curves."


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
    first = text.data.removeprefix(BOM).split(b"\n", 1)[0].rstrip(b"\r").decode("utf-8", "backslashreplace")
    names = first.split(",")
    if text.data.strip() and tuple(names) != text.header:
        close = next((did_you_mean(name, text.header) for name in names if name not in text.header), "")
        close = close if close.startswith("Did") else ""
        hint = f"Write {','.join(text.header)}. {close}".rstrip()
        yield Finding(f"{text.path}, row 1", f"The header is {first[:200]!r}.", hint)


@rule("text")
def odd_character(text: Text) -> Iterator[Finding]:
    """A log holds letters, digits and , . / + - alone (and the namespace): no quotes, no spaces, no tabs."""
    rest = text.data.removeprefix(BOM).replace(f"{NAMESPACE}/".encode(), b"")
    match = ODD.search(rest) if rest.translate(None, EVEN) else None
    if match:
        row = rest.count(b"\n", 0, match.start()) + 1
        found = f"The row holds the character {match[0].decode('latin-1')!r}."
        yield Finding(f"{text.path}, row {row}", found, REWRITE)


def _full(data: bytes, commas: int) -> bool:
    """Whether every line has that many commas and no cell is empty, found without cutting the text."""
    values = np.frombuffer(data, dtype=np.uint8)
    at = np.flatnonzero((values == COMMA) | (values == LINE_END))
    if not at.size or at[0] == 0 or (np.diff(at) == 1).any():
        return False
    ends = np.flatnonzero(values[at] == LINE_END)
    return bool((np.diff(ends, prepend=-1) == commas + 1).all())


@rule("text")
def cell_count(text: Text) -> Iterator[Finding]:
    """Every row has as many cells as the header, and none is empty."""
    commas = len(text.header) - 1
    if text.data.endswith(b"\n") and _full(text.data, commas):
        return
    rows = text.data.decode("utf-8", "backslashreplace").rstrip("\r\n").split("\n")[1:]
    wrong = [index for index, row in enumerate(rows) if row.count(",") != commas or "" in row.split(",")]

    def say(index: int) -> str:
        cells = rows[index].split(",")
        if len(cells) != len(text.header):
            return f"The row has {len(cells)} cells; {len(text.header)} are needed."
        return f"The cell {text.header[cells.index('')]!r} is empty."

    yield from told(text.path, wrong, say, "Write every cell of every row.")
