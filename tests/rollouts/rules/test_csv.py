"""Rules about the text of a CSV file."""

from __future__ import annotations

import random
import tracemalloc
from pathlib import Path

from gym_extensions.rollouts.episodes import EPISODE_COLUMNS
from gym_extensions.rollouts.reader import read
from gym_extensions.rollouts.reading.csv_lines import Text
from gym_extensions.rollouts.rules import problems

from ..examples import (
    GROUP,
    HALF,
    LOG,
    Check,
    CopySubmission,
    Example,
    all_of,
    cell,
    edit,
    lines,
    parametrize,
    put,
    row,
)

REWRITE = "Write the file with gym_extensions.rollouts.episodes.write_episodes or write_curves."

EXAMPLES = (
    Example(
        "too-many-rows",
        "more cells than the limit",
        lines(lambda _: ["x"] * 300_001),
        (
            (
                LOG,
                "The file has 300002 rows; the limit is 300000.",
                "Submit fewer runs or points of curves.",
            ),
        ),
    ),
    Example(
        "long-row",
        "a task name of a million letters",
        cell(2, 2, "a" * 10**6),
        ((f"{LOG}, row 2", "The row has more than 10000 characters.", REWRITE),),
    ),
    Example(
        "empty-file",
        "an empty log",
        put(LOG, b""),
        ((LOG, "The file is empty.", "Add the rows, or remove the file."),),
    ),
    Example(
        "empty-file",
        "a header without rows",
        lines(lambda _: []),
        ((LOG, "The file has a header but no rows.", "Add the rows, or remove the file."),),
    ),
    Example(
        "byte-order-mark",
        "a log saved by a spreadsheet",
        lambda folder: (folder / LOG).write_bytes(b"\xef\xbb\xbf" + (folder / LOG).read_bytes()),
        (
            (
                LOG,
                "The file starts with a byte order mark (EF BB BF).",
                "Save the file as UTF-8 without BOM.",
            ),
        ),
    ),
    Example(
        "line-ends",
        "a log saved on Windows",
        lambda folder: (folder / LOG).write_bytes((folder / LOG).read_bytes().replace(b"\n", b"\r\n")),
        ((LOG, "The file contains 1201 carriage returns (\\r).", "Save the file with \\n line ends."),),
    ),
    Example(
        "truncated-file",
        "a log that ends within a row",
        lambda folder: (folder / LOG).write_bytes((folder / LOG).read_bytes()[:-31]),
        (
            (
                f"{LOG}, row 1201",
                "The last line, '1,5,gym_extensions/HopperGravityOneAndHalf-v0,19,1400010033,1000,5', "
                "has no line end.",
                "The file may be truncated: copy or write it again.",
            ),
        ),
        also=("cell-count",),
    ),
    Example(
        "wrong-header",
        "a renamed column",
        edit("terminated", "terminate"),
        (
            (
                f"{LOG}, row 1",
                "The header is 'run,stage,task,episode,seed,length,return,terminate,success,fingerprint'.",
                "Write run,stage,task,episode,seed,length,return,terminated,success,fingerprint. "
                "Did you mean 'terminated'?",
            ),
        ),
    ),
    Example(
        "odd-character",
        "a quoted task",
        edit(HALF, f'"{HALF}"'),
        ((f"{LOG}, row 2", "The row contains the character '\"'.", REWRITE),),
    ),
    Example(
        "odd-character",
        "a digit of another script",
        cell(2, 5, "٣"),
        ((f"{LOG}, row 2", "The row contains the character '٣'.", REWRITE),),
    ),
    Example(
        "odd-character",
        "five rows, the header among them",
        all_of(edit("run,stage", "run, stage"), *(cell(number, 5, " 1000;") for number in (3, 5, 400, 1201))),
        (
            (f"{LOG}, row 1", "The row contains the character ' '.", REWRITE),
            (f"{LOG}, row 3", "The row contains the character ' '.", REWRITE),
            (f"{LOG}, row 5", "The row contains the character ' '.", REWRITE),
            (LOG, "2 more rows of this file break the same rule.", REWRITE),
        ),
        also=("wrong-header",),
    ),
    Example(
        "cell-count",
        "a row with a missing cell, and rows with an empty cell beside that of success",
        all_of(row(5, lambda cells: cells[:-1]), cell(7, 6, ""), cell(9, 9, "")),
        (
            (f"{LOG}, row 5", "The row has 9 cells; expected 10.", "Write every cell of every row."),
            (f"{LOG}, row 7", "Column `return` is empty.", "Write every cell of every row."),
            (f"{LOG}, row 9", "Column `fingerprint` is empty.", "Write every cell of every row."),
        ),
    ),
)


@parametrize(EXAMPLES)
def test_the_rule_reports_these_problems_and_no_other(example: Example, check: Check) -> None:
    check(example)


def test_millions_of_unreadable_rows_are_counted_in_bounded_memory() -> None:
    header = ",".join(EPISODE_COLUMNS).encode()
    tracemalloc.start()
    found = problems("text", Text(LOG, EPISODE_COLUMNS, header + b"\n" + b"a\n" * 2**22))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert [one.where for one in found] == [*(f"{LOG}, row {row}" for row in (2, 3, 4)), LOG]
    assert found[-1].message == "4194301 more rows of this file break the same rule."
    assert peak < 2**26


def test_damaged_logs_are_reported_and_never_raise(good: CopySubmission, tmp_path: Path) -> None:
    folder, rng = good(GROUP, tmp_path), random.Random(2)
    (folder / GROUP / "sequential.csv").unlink()
    (folder / GROUP / "curves.csv").unlink()
    log = folder / GROUP / "single.csv"
    whole = log.read_bytes()
    keys_changed = 0
    for _ in range(150):
        damaged = bytearray(whole)
        place = rng.randrange(len(damaged))
        damaged[place : place + rng.randrange(4)] = bytes(rng.choices(b"0123456789,.\ne-/true\x00\xff", k=2))
        log.write_bytes(bytes(damaged))
        rows = [
            (a, b) for a, b in zip(whole.split(b"\n"), bytes(damaged).split(b"\n"), strict=False) if a != b
        ]
        problems = read(folder).problems
        # A changed digit of a return may pass: only replay can notice it.
        if any(a.split(b",")[:6] != b.split(b",")[:6] for a, b in rows):
            keys_changed += 1
            assert problems, rows
    assert keys_changed > 75
