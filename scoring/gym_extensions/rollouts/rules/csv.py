"""Rules about the text of a CSV file, before its cells are parsed."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from string import ascii_letters, digits

import numpy as np

from gym_extensions.catalog.task import NAMESPACE
from gym_extensions.errors import did_you_mean
from gym_extensions.rollouts.layout import MAX_CELLS, MAX_ROW
from gym_extensions.rollouts.problem import MAX_QUOTE, ROWS_LISTED, Finding, row_findings
from gym_extensions.rollouts.reading.csv_lines import BOM, OPTIONAL, Text, lines
from gym_extensions.rollouts.rules.rule import rule

ALLOWED = (ascii_letters + digits + ",./\n\r+-").encode()
REWRITE = "Write the file with gym_extensions.rollouts.episodes.write_episodes or write_curves."


@rule("size")
def too_many_rows(text: Text) -> Iterator[Finding]:
    """A CSV file has at most 3,000,000 cells."""
    rows, limit = text.data.count(b"\n"), MAX_CELLS // len(text.header)
    if rows > limit:
        message = f"The file has {rows} rows; the limit is {limit}."
        yield Finding(text.path, message, "Submit fewer runs or points of curves.")


@rule("size")
def long_row(text: Text) -> Iterator[Finding]:
    """A row of a CSV file has at most 10,000 characters."""
    start = 0
    while len(text.data) - start > MAX_ROW:
        end = text.data.rfind(b"\n", start, start + MAX_ROW + 1) + 1
        if not end:
            row = text.data.count(b"\n", 0, start) + 1
            yield Finding(f"{text.path}, row {row}", f"The row has more than {MAX_ROW} characters.", REWRITE)
            return
        start = end


@rule("text")
def empty_file(text: Text) -> Iterator[Finding]:
    """A CSV file has a header and at least one row."""
    if text.data.count(b"\n") + (not text.data.endswith(b"\n")) < 2 or not text.data.strip():
        message = "The file is empty." if not text.data.strip() else "The file has a header but no rows."
        yield Finding(text.path, message, "Add the rows, or remove the file.")


@rule("text")
def byte_order_mark(text: Text) -> Iterator[Finding]:
    """A CSV file does not start with a byte order mark."""
    if text.data.startswith(BOM):
        message = "The file starts with a byte order mark (EF BB BF)."
        yield Finding(text.path, message, "Save the file as UTF-8 without BOM.")


@rule("text")
def line_ends(text: Text) -> Iterator[Finding]:
    r"""Lines of a CSV file end with \n."""
    count = text.data.count(b"\r")
    if count:
        message = f"The file contains {count} carriage return{'s' if count > 1 else ''} (\\r)."
        yield Finding(text.path, message, r"Save the file with \n line ends.")


@rule("text")
def truncated_file(text: Text) -> Iterator[Finding]:
    """The last line of a CSV file has a line end; without it, the line may be incomplete."""
    if text.data.strip() and not text.data.endswith((b"\n", b"\r")):
        row = text.data.count(b"\n") + 1
        last = text.data[text.data.rfind(b"\n") + 1 :][:80].decode("ascii", "backslashreplace")
        hint = "The file may be truncated: copy or write it again."
        yield Finding(f"{text.path}, row {row}", f"The last line, {last!r}, has no line end.", hint)


@rule("text")
def wrong_header(text: Text) -> Iterator[Finding]:
    """The first line names the columns of docs/rollout-log.md, in that order."""
    line = text.data.removeprefix(BOM).split(b"\n", 1)[0].rstrip(b"\r")
    first = line[:2000].decode("utf-8", "backslashreplace")
    names = first.split(",")
    if text.data.strip() and tuple(names) != text.header:
        unknown = next((name for name in names if name not in text.header), "")
        closest = did_you_mean(unknown[:MAX_QUOTE], text.header)
        closest = closest if closest.startswith("Did") else ""
        hint = f"Write {','.join(text.header)}. {closest}".rstrip()
        yield Finding(f"{text.path}, row 1", f"The header is {first[:200]!r}.", hint)


@rule("text")
def odd_character(text: Text) -> Iterator[Finding]:
    """Cells contain letters, digits and . / + - only (and the namespace): no quotes, spaces or tabs."""
    data = text.data.removeprefix(BOM).replace(f"{NAMESPACE}/".encode(), b"")
    if not data.translate(None, ALLOWED):
        return
    first: dict[int, str] = {}
    count = 0
    for block in lines(replace(text, data=data)):
        odd = np.flatnonzero(~np.isin(np.frombuffer(block.data, dtype=np.uint8), list(ALLOWED)))
        rows, indices = np.unique(np.searchsorted(block.ends, odd, side="right"), return_index=True)
        count += rows.size
        for row, offset in list(zip(rows, odd[indices], strict=True))[: ROWS_LISTED - len(first)]:
            text_there = block.data[offset : offset + 4].decode("utf-8", "backslashreplace")
            first[block.first + int(row) - 1] = text_there[:1]

    def message(row: int) -> str:
        return f"The row contains the character {first[row]!r}."

    yield from row_findings(text.path, list(first), message, REWRITE, more=count - len(first))


@rule("text")
def cell_count(text: Text) -> Iterator[Finding]:
    """Every row has as many cells as the header, and no cell is empty, except in `success`."""
    first: dict[int, str] = {}
    count = 0
    for block in lines(text):
        wrong = np.flatnonzero(block.wrong)
        wrong = wrong[wrong + block.first > 0]
        count += wrong.size
        for index in wrong[: ROWS_LISTED - len(first)].tolist():
            row = block.data[block.starts[index] : block.ends[index] - 1]
            first[block.first + index - 1] = row.decode("utf-8", "backslashreplace")

    def message(row: int) -> str:
        commas = first[row].count(",")
        if not first[row]:
            return "The row is empty."
        if commas != len(text.header) - 1:
            return f"The row has {commas + 1} cell{'s' if commas else ''}; expected {len(text.header)}."
        names = (name for name, cell in zip(text.header, first[row].split(","), strict=True) if not cell)
        return f"Column `{next(name for name in names if name != OPTIONAL)}` is empty."

    hint = "Write every cell of every row."
    yield from row_findings(text.path, list(first), message, hint, more=count - len(first))
