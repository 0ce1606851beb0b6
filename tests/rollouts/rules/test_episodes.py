"""Rules about the keys of a log."""

from __future__ import annotations

from gym_extensions.catalog.groups import group

from ..examples import GROUP, LOG, Check, Example, cell, lines, parametrize

ALL_TASKS = f"Choose one of: {', '.join(sorted(group(f'{GROUP}-v0').task_ids))}."

EXAMPLES = (
    Example(
        "foreign-task",
        "a task of another group and one that does not exist",
        lambda folder: (
            cell(2, 2, "gym_extensions/Humanoid-v0")(folder)
            or cell(3, 2, "gym_extensions/HopperGravityHalf-v1")(folder)
        ),
        (
            (
                f"{LOG}, row 2",
                "gym_extensions/Humanoid-v0 is not a task of hopper-gravity-v0.",
                "Did you mean 'gym_extensions/Hopper-v0'?",
            ),
            (
                f"{LOG}, row 3",
                "Unknown task 'gym_extensions/HopperGravityHalf-v1'.",
                "Did you mean 'gym_extensions/Hopper-v0'?",
            ),
        ),
        also=("missing-cell", "unsorted-rows"),
    ),
    Example(
        "foreign-task",
        "a task name of 9,000 letters",
        cell(2, 2, "a" * 9000),
        ((f"{LOG}, row 2", f"Unknown task '{'a' * 79}….", ALL_TASKS),),
        also=("missing-cell", "unsorted-rows"),
    ),
    Example(
        "wrong-stage",
        "a stage beyond the number of tasks",
        cell(1201, 1, "6"),
        (
            (
                f"{LOG}, row 1201",
                "Column `stage` is 6; expected 0 to 5.",
                "The stage is the number of tasks trained so far; it is 1 (trained) in single.csv and "
                "joint.csv.",
            ),
        ),
        also=("missing-cell",),
    ),
    Example(
        "wrong-episode",
        "a twenty-first episode",
        lines(lambda rows: [*rows[:20], rows[19].replace(",19,", ",20,", 1), *rows[20:]]),
        (
            (
                f"{LOG}, row 22",
                "Column `episode` is 20; expected 0 to 19.",
                "Evaluate 20 episodes per cell, numbered from 0.",
            ),
        ),
    ),
    Example(
        "wrong-seed",
        "a seed other than the prescribed one",
        cell(2, 4, "7"),
        (
            (
                f"{LOG}, row 2",
                "Column `seed` is 7; expected 315912130 for this episode.",
                "Reset with gym_extensions.catalog.protocol.evaluation_seed(group id, task id, episode).",
            ),
        ),
    ),
    Example(
        "duplicate-episode",
        "two rows for one episode",
        lines(lambda rows: [rows[0], *rows]),
        ((f"{LOG}, row 3", "Row 2 is the same episode.", "Keep only the row that was measured."),),
    ),
    Example(
        "missing-cell",
        "a cell without episodes",
        lines(lambda rows: rows[:20] + rows[40:]),
        (
            (
                LOG,
                "Run 0, stage 0, gym_extensions/HopperGravityThreeQuarters-v0 has 0 of 20 episodes.",
                "Finish the evaluation of this run, or leave out the whole run.",
            ),
        ),
    ),
    Example(
        "missing-cell",
        "a run without one of the tasks",
        lines(lambda rows: [line for line in rows if not (line[0] == "1" and "/Hopper-v0" in line)]),
        (
            *(
                (
                    LOG,
                    f"Run 1, stage {stage}, gym_extensions/Hopper-v0 has 0 of 20 episodes.",
                    "Finish the evaluation of this run, or leave out the whole run.",
                )
                for stage in range(3)
            ),
            (
                LOG,
                "Run 1 lacks episodes in 3 more cells.",
                "Finish the evaluation of this run, or leave out the whole run.",
            ),
        ),
    ),
    Example(
        "unsorted-rows",
        "two rows in the wrong order",
        lines(lambda rows: [rows[1], rows[0], *rows[2:]]),
        (
            (
                f"{LOG}, row 3",
                "The row should come before the row above it.",
                "Sort by run, stage, task in training order, episode.",
            ),
        ),
    ),
    Example(
        "reserved-run",
        "the training seed of a reference run",
        lambda folder: [
            lines(
                lambda rows: [row.replace("1,", "1000,", 1) if row[0] == "1" else row for row in rows], path
            )(folder)
            for path in (LOG, f"{GROUP}/single.csv")
        ],
        tuple(
            finding
            for path, first, more in ((LOG, 602, 597), (f"{GROUP}/single.csv", 102, 97))
            for finding in (
                *(
                    (
                        f"{path}, row {number}",
                        "Column `run` is 1000; expected 0 to 999.",
                        "Train with seeds from 0 to 999.",
                    )
                    for number in range(first, first + 3)
                ),
                (
                    path,
                    f"{more} more rows of this file break the same rule.",
                    "Train with seeds from 0 to 999.",
                ),
            )
        ),
        also=("gaps-in-runs",),
    ),
)


@parametrize(EXAMPLES)
def test_the_rule_reports_these_problems_and_no_other(example: Example, check: Check) -> None:
    check(example)
