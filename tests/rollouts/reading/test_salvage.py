"""A problem in one row hides no problem in another row, and no row is reported twice."""

from __future__ import annotations

from pathlib import Path

import pytest

from gym_extensions.rollouts.reader import read

from ..examples import GROUP, LOG, TOML, Change, CopySubmission, cell, edit, found, lines, row

CURVES = f"{GROUP}/curves.csv"


def without_row_102(rows: list[str]) -> list[str]:
    return rows[:100] + rows[101:]


def windows(folder: Path) -> None:
    data = (folder / LOG).read_bytes().replace(b"\n", b"\r\n")
    (folder / LOG).write_bytes(b"\xef\xbb\xbf" + data)


def cut_off(folder: Path) -> None:
    (folder / LOG).write_bytes((folder / LOG).read_bytes()[:-5])


HALF_A_ROW = (f"{LOG}, row 1201", "truncated-file")

EXAMPLES: dict[str, tuple[tuple[Change, ...], tuple[tuple[str, str], ...]]] = {
    "a word for a length, and a missing row": (
        (cell(6, 5, "abc"), lines(without_row_102)),
        ((f"{LOG}, row 6", "bad-cell"), (LOG, "missing-cell")),
    ),
    "a row of too few cells, and missing rows in two other cells": (
        (lines(lambda rows: [rows[0][:-1].rpartition(",")[0], *rows[1:100], *rows[101:200], *rows[201:]]),),
        (
            (f"{LOG}, row 2", "cell-count"),
            *[(LOG, "missing-cell")] * 3,
        ),
    ),
    "a row of too few cells, and as few missing": (
        (lines(lambda rows: [rows[0][:-1].rpartition(",")[0], *rows[1:]]),),
        ((f"{LOG}, row 2", "cell-count"),),
    ),
    "NaN in a run that single.csv lacks": (
        (
            cell(2, 6, "nan"),
            lines(lambda rows: [line for line in rows if line[0] == "0"], f"{GROUP}/single.csv"),
        ),
        (
            (f"{LOG}, row 2", "not-finite"),
            (f"{GROUP}/single.csv", "different-runs"),
            *((f"{CURVES}, row {number}", "foreign-curve") for number in (182, 183, 184)),
            (CURVES, "foreign-curve"),
        ),
    ),
    "a copied run, and another seed in it": (
        (
            lines(lambda rows: rows[:600] + ["1" + line[1:] for line in rows[:600]]),
            cell(700, 4, "7"),
        ),
        ((f"{LOG}, row 700", "wrong-seed"), (LOG, "identical-runs")),
    ),
    "an unknown key, and a curve beyond the budget": (
        (edit("boundaries = ", "luck = true\nboundaries = ", TOML), cell(13, 3, "99999", CURVES)),
        ((f"{TOML}, [observes] luck", "unknown-key"), (f"{CURVES}, row 13", "over-budget")),
    ),
    "a word for an episode alone": (
        (cell(6, 3, "abc"),),
        ((f"{LOG}, row 6", "bad-cell"),),
    ),
    "a row of too few cells, and NaN behind it": (
        (cell(9, 6, "nan"), row(5, lambda cells: cells[:-1])),
        ((f"{LOG}, row 5", "cell-count"), (f"{LOG}, row 9", "not-finite")),
    ),
    "a blank line, and rows behind it in a wrong order": (
        (lines(lambda rows: [*rows[:20], "", *rows[20:30], rows[31], rows[30], *rows[32:]]),),
        ((f"{LOG}, row 22", "cell-count"), (f"{LOG}, row 34", "unsorted-rows")),
    ),
    "a quoted task, and another seed behind it": (
        (cell(9, 4, "7"), cell(5, 2, '"Hopper"')),
        ((f"{LOG}, row 5", "odd-character"), (f"{LOG}, row 9", "wrong-seed")),
    ),
    "a row that stands twice behind one that cannot be read": (
        (lines(lambda rows: [*rows[:8], rows[7], *rows[8:]]), cell(5, 6, "")),
        ((f"{LOG}, row 5", "cell-count"), (f"{LOG}, row 10", "duplicate-episode")),
    ),
    "a log saved on Windows, and a length below 0": (
        (cell(6, 5, "-3"), windows),
        ((LOG, "byte-order-mark"), (LOG, "line-ends"), (f"{LOG}, row 6", "impossible-length")),
    ),
    "a log cut off within its last cell": ((cut_off,), (HALF_A_ROW,)),
    "another header": ((edit("terminated", "end"), cell(6, 5, "abc")), ((f"{LOG}, row 1", "wrong-header"),)),
    "no row that can be read": (
        (lines(lambda rows: [f"{line},1" for line in rows[:2]]),),
        tuple((f"{LOG}, row {number}", "cell-count") for number in (2, 3)),
    ),
    "a curve with a step that is a word, and NaN behind it": (
        (cell(4, 3, "ten", CURVES), cell(6, 4, "nan", CURVES)),
        ((f"{CURVES}, row 4", "bad-cell"), (f"{CURVES}, row 6", "curve-not-finite")),
    ),
}


@pytest.mark.parametrize("title", EXAMPLES)
def test_every_problem_of_a_file_is_reported_once(title: str, good: CopySubmission, tmp_path: Path) -> None:
    folder = good(GROUP, tmp_path)
    changes, expected = EXAMPLES[title]
    for change in changes:
        change(folder)
    assert found(read(folder).problems) == list(expected)
