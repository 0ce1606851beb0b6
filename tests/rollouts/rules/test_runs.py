"""Rules about the logs of one group together."""

from __future__ import annotations

from ..examples import GROUP, LOG, Check, Example, lines, parametrize

EXAMPLES = (
    Example(
        "different-runs",
        "a run without a single log, but with its curves",
        lines(lambda rows: [line for line in rows if line[0] == "0"], f"{GROUP}/single.csv"),
        (
            (
                f"{GROUP}/single.csv",
                "The runs are [0]; sequential.csv has [0, 1].",
                "Add the missing runs to either file, or leave them out of both.",
            ),
        ),
        also=("foreign-curve",),
    ),
    Example(
        "too-many-runs",
        "a run per row",
        lines(lambda rows: [f"{run}{line[1:]}" for run, line in enumerate(rows[:101])]),
        ((LOG, "The log has 101 runs; the limit is 100.", "Submit the runs 0 to 99."),),
    ),
    Example(
        "gaps-in-runs",
        "runs 0 and 2",
        lines(lambda rows: rows[:600] + ["2" + line[1:] for line in rows[600:]]),
        (
            (
                LOG,
                "The runs are [0, 2]; of 0 to 2, these are missing: [1].",
                "Train the missing runs; no run may be left out.",
            ),
        ),
        also=("different-runs", "foreign-curve"),
    ),
    Example(
        "identical-runs",
        "a run copied under another seed",
        lines(lambda rows: rows[:600] + ["1" + line[1:] for line in rows[:600]]),
        (
            (
                LOG,
                "Run 1 is identical to run 0 in every episode.",
                "Train each run with its own seed; for an agent without parameters, say so in [memory].",
            ),
        ),
    ),
)


@parametrize(EXAMPLES)
def test_the_rule_reports_these_problems_and_no_other(example: Example, check: Check) -> None:
    check(example)
