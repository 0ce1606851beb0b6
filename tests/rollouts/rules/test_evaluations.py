"""Rules about evaluations.csv."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from gym_extensions.rollouts.reader import read

from ..examples import GROUP, HALF, Change, Check, CopySubmission, Example, parametrize, put

PATH = f"{GROUP}/evaluations.csv"
HEADER = "protocol,run,stage,task,step,episodes,return\n"
VALID = (
    f"sequential,0,1,{HALF},500,5,12.5",
    "sequential,0,1,gym_extensions/Hopper-v0,500,5,12.5",
    f"sequential,0,2,{HALF},500,5,12.5",
    f"single,1,1,{HALF},999,20,-3.0",
)
ORDER = "Sort by protocol, run, stage, step and task in training order; write each evaluation once."
FOREIGN = "Include only evaluations during the training of logged runs."
STEP = "Count steps from the beginning of the stage; the log has the evaluation at its end."
MEAN = "Write the mean of the undiscounted, unscaled returns of the episodes."


def evaluations(*rows: str) -> Change:
    return put(PATH, (HEADER + "".join(f"{row}\n" for row in rows)).encode())


def example(rule: str, title: str, row: str, message: str, hint: str) -> Example:
    """A file whose only row breaks the rule."""
    return Example(rule, title, evaluations(row), ((f"{PATH}, row 2", message, hint),))


EXAMPLES = (
    example(
        "foreign-evaluation",
        "of a run that is not logged",
        f"single,2,1,{HALF},500,5,12.5",
        "single.csv has no run 2.",
        FOREIGN,
    ),
    example(
        "foreign-evaluation",
        "of a stage without training",
        f"sequential,0,0,{HALF},500,5,12.5",
        "Stage 0 of sequential.csv has no training.",
        FOREIGN,
    ),
    example(
        "foreign-evaluation",
        "of a stage that the protocol does not have",
        f"single,0,2,{HALF},500,5,12.5",
        "Stage 2 of single.csv has no training.",
        FOREIGN,
    ),
    example(
        "foreign-evaluation",
        "of an unknown protocol",
        f"parallel,0,1,{HALF},500,5,12.5",
        "Unknown protocol 'parallel'.",
        FOREIGN,
    ),
    example(
        "foreign-evaluation",
        "of a task of another group",
        "sequential,0,1,gym_extensions/Walker2d-v0,500,5,12.5",
        "'gym_extensions/Walker2d-v0' is not a task of hopper-gravity-v0.",
        FOREIGN,
    ),
    Example(
        "evaluation-order",
        "an evaluation that is written twice",
        evaluations(VALID[0], VALID[0]),
        ((f"{PATH}, row 3", f"Step 500 of '{HALF}' is not in order.", ORDER),),
    ),
    example(
        "evaluation-episodes",
        "more episodes than prescribed seeds",
        f"sequential,0,1,{HALF},500,21,12.5",
        "Column `episodes` is 21.",
        "Write the number of episodes, 1 to 20.",
    ),
    example(
        "evaluation-step",
        "at the end of the stage",
        f"sequential,0,1,{HALF},1000,5,12.5",
        "Step 1000 is not between 1 and the end of the stage.",
        STEP,
    ),
    example(
        "evaluation-step",
        "before the stage",
        f"sequential,0,1,{HALF},0,5,12.5",
        "Step 0 is not between 1 and the end of the stage.",
        STEP,
    ),
    example(
        "impossible-evaluation-return",
        "outside the bounds of the task",
        f"sequential,0,1,{HALF},500,5,20000.5",
        "Column `return` is 20000.5; no episodes have this mean.",
        MEAN,
    ),
    example(
        "impossible-evaluation-return",
        "not a number",
        f"sequential,0,1,{HALF},500,5,nan",
        "Column `return` is nan; no episodes have this mean.",
        MEAN,
    ),
)


@parametrize(EXAMPLES)
def test_the_rule_reports_these_problems_and_no_other(example: Example, check: Check) -> None:
    check(example)


def test_evaluations_that_belong_to_the_logs_are_no_problem(good: CopySubmission, tmp_path: Path) -> None:
    folder = good(GROUP, tmp_path)
    evaluations(*VALID)(folder)
    submission = read(folder)
    assert submission.problems == ()
    rows = submission.groups["hopper-gravity-v0"].evaluations
    assert rows is not None
    assert rows.return_.tolist() == [12.5, 12.5, 12.5, -3.0]


@pytest.mark.parametrize(
    ("row", "rule"),
    [(f"sequential,0,one,{HALF},500,5,1.0", "bad-cell"), (f"sequential,0,1,{HALF},500,5", "cell-count")],
)
def test_a_row_that_cannot_be_read_is_a_problem_and_the_others_are_checked(
    row: str, rule: str, submission: Callable[..., Path]
) -> None:
    folder = submission()
    evaluations(row, f"sequential,0,1,{HALF},500,0,1.0")(folder)
    assert {(problem.rule, problem.where) for problem in read(folder).problems} == {
        (rule, f"{PATH}, row 2"),
        ("evaluation-episodes", f"{PATH}, row 3"),
    }
