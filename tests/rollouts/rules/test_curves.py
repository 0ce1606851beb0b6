"""Rules about curves.csv."""

from __future__ import annotations

from ..examples import GROUP, Check, Example, cell, lines, parametrize

ORDER = "Sort by protocol, run, task in training order and step; every curve counts its steps from 0."

EXAMPLES = (
    Example(
        "foreign-curve",
        "the curve of a run that is not logged",
        lines(lambda rows: [*rows, "single,2,gym_extensions/Hopper-v0,10,1.0"], f"{GROUP}/curves.csv"),
        (
            (
                f"{GROUP}/curves.csv, row 242",
                "single.csv has no run 2.",
                "Include only the curves of logged runs.",
            ),
        ),
    ),
    Example(
        "curve-order",
        "a step that goes back",
        cell(4, 3, "10", f"{GROUP}/curves.csv"),
        (
            (
                f"{GROUP}/curves.csv, row 4",
                "Step 10 does not follow the row above.",
                ORDER,
            ),
        ),
    ),
    Example(
        "curve-order",
        "a row of another curve inside a curve",
        lines(lambda rows: [*rows[:3], rows[-1], *rows[3:-1]], f"{GROUP}/curves.csv"),
        (
            (
                f"{GROUP}/curves.csv, row 5",
                "Step 1000 does not follow the row above.",
                ORDER,
            ),
        ),
    ),
    Example(
        "foreign-curve",
        "a row with an unknown protocol inside a curve",
        cell(4, 0, "parallel", f"{GROUP}/curves.csv"),
        (
            (
                f"{GROUP}/curves.csv, row 4",
                "Unknown protocol 'parallel'.",
                "Include only the curves of logged runs.",
            ),
        ),
    ),
    Example(
        "impossible-curve-return",
        "a return outside the bounds of the task",
        lambda folder: [
            cell(number, 4, value, f"{GROUP}/curves.csv")(folder)
            for number, value in ((4, "1e+308"), (5, "-20000.5"))
        ],
        tuple(
            (
                f"{GROUP}/curves.csv, row {number}",
                f"Column `return` is {value}; an episode of this task returns -20000 to 20000.",
                "Write the mean of the undiscounted, unscaled returns of the episodes that ended.",
            )
            for number, value in ((4, "1e+308"), (5, "-20000.5"))
        ),
    ),
    Example(
        "curve-not-finite",
        "NaN in a curve",
        cell(4, 4, "nan", f"{GROUP}/curves.csv"),
        (
            (
                f"{GROUP}/curves.csv, row 4",
                "Column `return` is nan; expected a finite number.",
                "Leave out rows in which no episode ended; find the cause of other NaN or infinite values.",
            ),
        ),
    ),
    Example(
        "over-budget",
        "a curve beyond the budget",
        cell(13, 3, "1021", f"{GROUP}/curves.csv"),
        (
            (
                f"{GROUP}/curves.csv, row 13",
                "Step 1021 exceeds the budget 'smoke' of 1000 steps.",
                "Train within the budget, or name the larger budget in submission.toml.",
            ),
        ),
    ),
)


@parametrize(EXAMPLES)
def test_the_rule_reports_these_problems_and_no_other(example: Example, check: Check) -> None:
    check(example)
