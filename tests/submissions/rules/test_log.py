"""Every rule about logs reports its mistake."""

from collections.abc import Callable
from pathlib import Path
from shutil import copyfile

from gym_extensions.submissions.reader import read

from ..examples import HALF, LOG, Change, Example, cell, lines, redigest


def logged(number: int, column: int, value: str, path: str = LOG) -> Change:
    """Writes another value into a cell of a log (the header is line 1), and its digest in the document."""
    return redigest(cell(number, column, value, path), path)


def line(number: int, path: str = LOG) -> str:
    return f"{path}, line {number}"


PUSHER, NAV = "pusher/sequential/run0.csv", "nav-state/single/run0.csv"

EXAMPLES = (
    Example(
        "foreign-task",
        "a task of another group",
        logged(22, 1, "gym_extensions/HopperGravityHolf-v0"),
        line(22),
        f"Did you mean {HALF!r}",
        also=("missing-cell", "unsorted-rows"),
    ),
    Example(
        "wrong-stage",
        "a stage that does not exist",
        logged(601, 0, "6"),
        line(601),
        "is 6; expected 0 to 5",
        also=("missing-cell",),
    ),
    Example(
        "wrong-episode", "numbered from 1", logged(21, 2, "20"), line(21), "is 20", also=("missing-cell",)
    ),
    Example("wrong-seed", "a seed of one's own", logged(5, 3, "7"), line(5), "is 7; expected"),
    Example(
        "unsorted-rows",
        "rows exchanged",
        redigest(lines(lambda rows: [rows[1], rows[0], *rows[2:]])),
        line(3),
        "episode 0 does not follow",
    ),
    Example(
        "unsorted-rows",
        "an episode twice",
        redigest(lines(lambda rows: [*rows[:5], rows[4], *rows[5:]])),
        line(7),
        "write each episode once",
    ),
    Example(
        "missing-cell",
        "one episode is missing",
        redigest(lines(lambda rows: rows[:-1])),
        LOG,
        "has 19 of 20 episodes",
    ),
    Example(
        "missing-cell",
        "a stage is missing: three cells are listed, the others counted",
        redigest(lines(lambda rows: rows[:500])),
        LOG,
        f"Stage 5, {HALF} has 0 of 20",
        count=4,
    ),
    Example("not-finite", "an infinite return", logged(4, 5, "inf"), line(4), "is inf"),
    Example("impossible-length", "longer than the time limit", logged(4, 4, "1001"), line(4), "1 to 1000"),
    Example("unfinished-episode", "cut off", logged(4, 4, "999"), line(4), "999 of 1000 steps"),
    Example(
        "impossible-end",
        "the time limit written as an end",
        logged(4, 6, "true", PUSHER),
        line(4, PUSHER),
        "never terminates",
        group="pusher",
    ),
    Example("impossible-return", "scaled rewards", logged(4, 5, "1e9"), line(4), "is 1000000000.0"),
    Example(
        "missing-success",
        "no success where it is defined",
        logged(4, 7, "", NAV),
        line(4, NAV),
        "is empty",
        group="nav-state",
    ),
    Example(
        "undefined-success", "a success of running", logged(4, 7, "false"), line(4), "defines no success"
    ),
    Example(
        "contradictory-success",
        "an arrival that did not end the episode",
        logged(4, 7, "true", NAV),
        line(4, NAV),
        "is true, but `terminated` is false",
        group="nav-state",
    ),
    Example(
        "contradictory-success",
        "an end that is no arrival",
        logged(4, 6, "true", NAV),
        line(4, NAV),
        "is false, but `terminated` is true",
        also=("impossible-return",),
        group="nav-state",
    ),
    Example(
        "identical-runs",
        "a run copied",
        lambda folder: copyfile(folder / LOG, folder / "hopper-gravity/sequential/run1.csv"),
        "hopper-gravity/sequential/run1.csv",
        "identical to run 0",
        also=("different-log",),
    ),
)


def test_many_bad_rows_are_counted_not_listed(make_submission: Callable[..., Path]) -> None:
    folder = make_submission(runs=(0,), protocols=("sequential",))
    (folder / LOG).write_text((folder / LOG).read_text().replace(",1000,", ",1001,"))
    found = [p for p in read(folder).problems if p.rule == "impossible-length"]
    assert [problem.where for problem in found] == [line(2), line(3), line(4), "hopper-gravity/sequential"]
    assert found[-1].message.startswith("597 more rows")
