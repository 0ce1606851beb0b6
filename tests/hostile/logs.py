"""Hostile CSV files: sizes, runs, cells, and floods of problems."""

from __future__ import annotations

from pathlib import Path

from gym_extensions.rollouts.layout import MEBIBYTE

from ..rollouts.examples import Change
from .case import GROUP, LOG, TRACES, Case, all_of, cell, lines, put

HEADER = b"run,stage,task,episode,seed,length,return,terminated,success,trace,fingerprint\n"
UNBOUND = HEADER.replace(b"trace,", b"")
CURVES, EVALUATIONS = f"{GROUP}/curves.csv", f"{GROUP}/evaluations.csv"
CURVE_HEADER = b"protocol,run,task,step,return\n"
EVALUATION_HEADER = b"protocol,run,stage,task,step,episodes,return\n"
TASK = b"gym_extensions/HopperGravityHalf-v0"
SHORT = b"0,0,a,0,0,1,1,true,,0,0\n"
LOG_LIMIT = 32 * MEBIBYTE


def filled(header: bytes, row: bytes, size: int = LOG_LIMIT, path: str = LOG) -> Change:
    """A file of nearly that many bytes with the same row again and again."""
    return put(path, lambda: header + row * ((size - len(header)) // len(row)))


def runs(count: int, path: str = LOG) -> Change:
    """A log of that many different runs, which all end well."""

    def change(folder: Path) -> None:
        for trace in (folder / TRACES).iterdir():
            trace.unlink()
        text = (folder / "submission.toml").read_text()
        (folder / "submission.toml").write_text(text[: text.index("[traces]")])
        rows = [line.split(",") for line in (folder / path).read_text().splitlines()[1:]]
        cells = [[row[column] for column in (0, 1, 2, 3, 4, 5, 6, 7, 8, 10)] for row in rows]
        text = "".join(
            f"{run},{','.join(row[1:6])},{float(row[6]) + run / 8!r},{','.join(row[7:])}\n"
            for run in range(count)
            for row in cells
        )
        (folder / path).write_bytes(UNBOUND + text.encode())

    return change


def every(column: int, content: str) -> Change:
    """Writes the same cell into a column of every row."""
    return lines(
        lambda rows: [
            ",".join([*row.split(",")[:column], content, *row.split(",")[column + 1 :]]) for row in rows
        ]
    )


CASES = (
    Case("a log of the largest size with short rows", filled(HEADER, SHORT), ("too-many-rows",)),
    Case("a log of line ends", filled(HEADER, b"\n"), ("too-many-rows",)),
    Case("a log of commas", filled(HEADER, b"," * 1000), ("long-row",)),
    Case(
        "a log of zeros",
        filled(b"", b"\0"),
        ("long-row",),
    ),
    Case("a log of one long row", filled(HEADER, b"a"), ("long-row",)),
    Case("a log of quotes", filled(HEADER, b'"\n'), ("too-many-rows",)),
    Case("a log of 64 MiB", filled(HEADER, SHORT, 64 * MEBIBYTE), ("too-large",)),
    Case(
        "three logs of the largest size",
        all_of(
            *(filled(HEADER, SHORT, path=f"{GROUP}/{name}.csv") for name in ("single", "sequential", "joint"))
        ),
        ("too-many-rows",),
    ),
    Case(
        "curves of the largest size",
        filled(CURVE_HEADER, b"single,0,%b,1,1\n" % TASK, path=CURVES),
        ("too-many-rows",),
    ),
    Case("curves of short rows", filled(CURVE_HEADER, b"a,0,a,1,1\n", path=CURVES), ("too-many-rows",)),
    Case(
        "evaluations of short rows",
        filled(EVALUATION_HEADER, b"a,0,0,a,1,1,1\n", path=EVALUATIONS),
        ("too-many-rows",),
    ),
    Case("100 runs", runs(100)),
    Case("100 runs on the page", runs(100), command="pages"),
    Case("1,000 runs", runs(1000), ("too-many-runs",)),
    Case(
        "a run of the number 999,999,999,999,999",
        every(0, "999999999999999"),
        ("gaps-in-runs", "reserved-run"),
    ),
    Case("a negative run", every(0, "-1"), ("gaps-in-runs", "reserved-run")),
    Case("a run of 30 digits", every(0, "9" * 30), ("bad-cell",)),
    Case("a run of a million digits", cell(2, 0, "9" * 1_000_000), ("long-row",)),
    Case("a run in other digits", every(0, "٣"), ("odd-character",)),
    Case(
        "a stage of the number 999,999,999,999,999",
        every(1, "999999999999999"),
        ("missing-cell", "wrong-stage"),
    ),
    Case(
        "an episode of the number 999,999,999,999,999",
        every(3, "999999999999999"),
        ("duplicate-episode", "missing-cell", "wrong-episode"),
    ),
    Case("a seed of a million digits", cell(2, 4, "1" * 1_000_000), ("long-row",)),
    Case("a length of zero", every(5, "0"), ("impossible-length",)),
    Case("a return of a million digits", cell(2, 6, "1" + "0" * 1_000_000), ("long-row",)),
    Case("returns that overflow", every(6, "1e308"), ("impossible-return",)),
    Case("returns that are infinite", every(6, "inf"), ("not-finite",)),
    Case("returns that are no numbers", every(6, "nan"), ("not-finite",)),
    Case("returns in hexadecimal", every(6, "0x1p3"), ("bad-cell",)),
    Case("returns with underscores", every(6, "1_0.0"), ("odd-character",)),
    Case("returns of the least size", every(6, "5e-324"), ()),
    Case(
        "a task of a million letters",
        cell(2, 2, "a" * 1_000_000),
        ("long-row",),
    ),
    Case(
        "tasks that are all different",
        lines(lambda rows: [row.replace("Hopper", f"Hopper{i}", 1) for i, row in enumerate(rows)]),
        ("foreign-task", "missing-cell", "unsorted-rows"),
    ),
    Case("a digest that is not hexadecimal", every(9, "g" * 32), ("bad-cell",)),
    Case("a digest of a million digits", cell(2, 9, "0" * 1_000_000), ("long-row",)),
    Case("a fingerprint of a million letters", cell(2, 10, "a" * 1_000_000), ("long-row",)),
    Case(
        "a header of a million columns",
        put(LOG, lambda: b"run," * 1_000_000 + b"\n1\n"),
        ("long-row",),
    ),
    Case("a header alone", put(LOG, HEADER), ("empty-file",)),
    Case("an empty log", put(LOG, b""), ("empty-file",)),
    Case(
        "a log in UTF-16",
        put(LOG, HEADER.decode().encode("utf-16")),
        ("cell-count", "odd-character", "truncated-file", "wrong-header"),
    ),
    Case(
        "line ends of another system",
        lambda folder: (folder / LOG).write_bytes((folder / LOG).read_bytes().replace(b"\n", b"\r\n")),
        ("line-ends",),
    ),
    Case("carriage returns in cells", every(6, "1\r2"), ("line-ends",)),
    Case("a formula in a cell", every(6, "=1+1"), ("odd-character",), "table"),
    Case(
        "a formula as a task",
        every(2, "+cmd"),
        ("duplicate-episode", "foreign-task", "missing-cell", "unsorted-rows"),
        "table",
    ),
    Case("rows in the wrong order", lines(lambda rows: rows[::-1]), ("unsorted-rows",)),
    Case(
        "the same row 3,000 times",
        lines(lambda rows: rows[:1] * 3_000),
        ("duplicate-episode", "missing-cell"),
    ),
    Case(
        "a curve that changes its task in every row",
        put(CURVES, lambda: CURVE_HEADER + b"".join(b"single,0,t%d,1,1\n" % i for i in range(50_000))),
        ("foreign-curve",),
    ),
    Case(
        "a curve of runs that do not exist",
        put(
            CURVES,
            lambda: CURVE_HEADER + b"".join(b"single,%d,%b,1,1\n" % (i + 1, TASK) for i in range(50_000)),
        ),
        ("foreign-curve",),
    ),
    Case(
        "a curve of 50,000 points",
        put(
            CURVES,
            lambda: CURVE_HEADER + b"".join(b"single,0,%b,%d,1\n" % (TASK, i + 1) for i in range(50_000)),
        ),
        ("over-budget",),
    ),
)
