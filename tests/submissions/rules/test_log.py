"""Every rule about logs reports its mistake."""

from collections.abc import Callable
from pathlib import Path
from shutil import copyfile

from gym_extensions.submissions.reader import read

from ..examples import HALF, LOG, Change, Table, cell, lines, redigest


def logged(number: int, column: int, value: str, path: str = LOG) -> Change:
    """Writes another value into a cell of a log (the header is line 1), and its digest in the document."""
    return redigest(cell(number, column, value, path), path)


def with_rows(change: Callable[[list[str]], list[str]]) -> Change:
    return redigest(lines(change))


def line(number: int, path: str = LOG) -> str:
    return f"{path}, line {number}"


PUSHER, NAV = "pusher/sequential/run0.csv", "nav-state/single/run0.csv"
OTHER, MISSING = "hopper-gravity/sequential/run1.csv", ("missing-cell",)
TYPO = HALF.replace("Half", "Holf")

EXAMPLES: Table = {
    "foreign-task": [
        ("no task", logged(22, 1, TYPO), line(22), f"Did you mean {HALF!r}", (*MISSING, "unsorted-rows")),
    ],
    "wrong-stage": [("no stage", logged(601, 0, "6"), line(601), "is 6; expected 0 to 5", MISSING)],
    "wrong-episode": [("numbered from 1", logged(21, 2, "20"), line(21), "is 20", MISSING)],
    "wrong-seed": [("a seed of one's own", logged(5, 3, "7"), line(5), "is 7; expected")],
    "unsorted-rows": [
        ("exchanged", with_rows(lambda rows: [rows[1], rows[0], *rows[2:]]), line(3), "0 does not follow"),
        ("twice", with_rows(lambda rows: [*rows[:5], *rows[4:]]), line(7), "write each episode once"),
    ],
    "missing-cell": [
        ("one episode", with_rows(lambda rows: rows[:-1]), LOG, "has 19 of 20 episodes"),
        ("three listed, the others counted", with_rows(lambda rows: rows[:500]), LOG, "0 of 20", (), 4),
    ],
    "not-finite": [("an infinite return", logged(4, 5, "inf"), line(4), "is inf")],
    "impossible-length": [("longer than the limit", logged(4, 4, "1001"), line(4), "1 to 1000")],
    "unfinished-episode": [("cut off", logged(4, 4, "999"), line(4), "999 of 1000 steps")],
    "impossible-end": [
        (
            "the time limit",
            logged(4, 6, "true", PUSHER),
            line(4, PUSHER),
            "never terminates",
            (),
            1,
            "pusher",
        ),
    ],
    "impossible-return": [("scaled rewards", logged(4, 5, "1e9"), line(4), "is 1000000000.0")],
    "missing-success": [
        ("where it is defined", logged(4, 7, "", NAV), line(4, NAV), "is empty", (), 1, "nav-state"),
    ],
    "undefined-success": [("of running", logged(4, 7, "false"), line(4), "defines no success")],
    "contradictory-success": [
        (
            *("a goal that does not end the episode", logged(4, 7, "true", NAV), line(4, NAV)),
            *("is true, but `terminated` is false", (), 1, "nav-state"),
        ),
        (
            *("an end that is no arrival", logged(4, 6, "true", NAV), line(4, NAV)),
            *("is false, but `terminated` is true", ("impossible-return",), 1, "nav-state"),
        ),
    ],
    "identical-runs": [
        (
            *("a run copied", lambda folder: copyfile(folder / LOG, folder / OTHER)),
            *(OTHER, "identical to run 0", ("different-log",)),
        ),
    ],
}


def test_many_bad_rows_are_counted_not_listed(make_submission: Callable[..., Path]) -> None:
    folder = make_submission(runs=(0,), protocols=("sequential",))
    (folder / LOG).write_text((folder / LOG).read_text().replace(",1000,", ",1001,"))
    found = [p for p in read(folder).problems if p.rule == "impossible-length"]
    assert [problem.where for problem in found] == [line(2), line(3), line(4), "hopper-gravity/sequential"]
    assert found[-1].message.startswith("597 more rows")
