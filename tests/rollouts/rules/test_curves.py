"""Rules about curves.csv."""

from __future__ import annotations

from .broken import GROUP, Broken, Judge, cell, each, lines

BROKEN = (
    Broken(
        "foreign-curve",
        "the curve of a run that is not logged",
        lines(lambda rows: [*rows, "single,2,gym_extensions/Hopper-v0,10,1.0"], f"{GROUP}/curves.csv"),
        (
            (
                f"{GROUP}/curves.csv, row 242",
                "single.csv has no run 2.",
                "Keep the curves of the runs that are logged.",
            ),
        ),
    ),
    Broken(
        "curve-order",
        "a step that goes back",
        cell(4, 3, "10", f"{GROUP}/curves.csv"),
        (
            (
                f"{GROUP}/curves.csv, row 4",
                "Step 10 does not follow the row above.",
                "Sort by protocol, run, task in training order and step; steps count from 0 in every curve.",
            ),
        ),
    ),
    Broken(
        "curve-order",
        "a row of another curve inside a curve",
        lines(lambda rows: [*rows[:3], rows[-1], *rows[3:-1]], f"{GROUP}/curves.csv"),
        (
            (
                f"{GROUP}/curves.csv, row 5",
                "Step 1000 does not follow the row above.",
                "Sort by protocol, run, task in training order and step; steps count from 0 in every curve.",
            ),
        ),
    ),
    Broken(
        "foreign-curve",
        "a row of no protocol inside a curve",
        cell(4, 0, "parallel", f"{GROUP}/curves.csv"),
        (
            (
                f"{GROUP}/curves.csv, row 4",
                "There is no protocol 'parallel'.",
                "Keep the curves of the runs that are logged.",
            ),
        ),
    ),
    Broken(
        "impossible-curve-return",
        "a return that no episode can have",
        lambda folder: [
            cell(number, 4, value, f"{GROUP}/curves.csv")(folder)
            for number, value in ((4, "1e+308"), (5, "-20000.5"))
        ],
        tuple(
            (
                f"{GROUP}/curves.csv, row {number}",
                f"The return is {value}; an episode of this task gives from -20000 to 20000.",
                "Write the mean of the undiscounted, unscaled returns of the episodes that ended.",
            )
            for number, value in ((4, "1e+308"), (5, "-20000.5"))
        ),
    ),
    Broken(
        "curve-not-finite",
        "NaN in a curve",
        cell(4, 4, "nan", f"{GROUP}/curves.csv"),
        (
            (
                f"{GROUP}/curves.csv, row 4",
                "The return is nan.",
                "Leave the row out where no episode ended; find the cause of NaN elsewhere.",
            ),
        ),
    ),
    Broken(
        "over-budget",
        "a curve beyond the budget",
        cell(13, 3, "1021", f"{GROUP}/curves.csv"),
        (
            (
                f"{GROUP}/curves.csv, row 13",
                "Step 1021 is beyond the budget 'smoke', which is 1000 steps here.",
                "Train within the budget, or name the larger budget in submission.toml.",
            ),
        ),
    ),
)


@each(BROKEN)
def test_a_broken_folder_breaks_its_rule_and_says_so(example: Broken, judge: Judge) -> None:
    judge(example)
