"""Rules about the measured cells of a log."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from gym_extensions.catalog.registry import TASKS
from gym_extensions.catalog.task import Task
from gym_extensions.rollouts.reader import read

from ..examples import LOG, Check, Example, cell, edit, parametrize, row

COUNT_STEPS = "Count the steps from the reset to the end of the episode."

EXAMPLES = (
    Example(
        "bad-cell",
        "a length with a point and a word for a return",
        lambda folder: cell(3, 5, "1000.0")(folder) or cell(4, 6, "many")(folder),
        (
            (f"{LOG}, row 3", "Column `length` is '1000.0'; expected an integer.", "Write an integer."),
            (f"{LOG}, row 4", "Column `return` is 'many'; expected a number.", "Write a number."),
        ),
    ),
    Example(
        "bad-cell",
        "True in place of true",
        cell(3, 7, "True"),
        (
            (
                f"{LOG}, row 3",
                "Column `terminated` is 'True'; expected true or false.",
                "Write true or false.",
            ),
        ),
    ),
    Example(
        "not-finite",
        "NaN and infinity",
        lambda folder: cell(2, 6, "nan")(folder) or cell(3, 6, "-inf")(folder),
        (
            (
                f"{LOG}, row 2",
                "Column `return` is nan; expected a finite number.",
                "Find the cause in the policy or in the sum of rewards; such an episode cannot be scored.",
            ),
            (
                f"{LOG}, row 3",
                "Column `return` is -inf; expected a finite number.",
                "Find the cause in the policy or in the sum of rewards; such an episode cannot be scored.",
            ),
        ),
    ),
    Example(
        "impossible-length",
        "episodes that are too long, empty and negative",
        lambda folder: [
            cell(number, 5, steps)(folder) for number, steps in ((2, "1001"), (3, "0"), (4, "-5"))
        ],
        tuple(
            (
                f"{LOG}, row {number}",
                f"Column `length` is {steps}; expected 1 to 1000 steps.",
                COUNT_STEPS,
            )
            for number, steps in ((2, 1001), (3, 0), (4, -5))
        ),
    ),
    Example(
        "unfinished-episode",
        "an episode that stops before its end",
        cell(2, 5, "999"),
        (
            (
                f"{LOG}, row 2",
                "The episode ends after 999 of 1000 steps, but `terminated` is false.",
                "Evaluate every episode to its end; write true in `terminated` if the task ended it.",
            ),
        ),
    ),
    Example(
        "impossible-return",
        "a return beyond what the task can give in that many steps",
        row(2, lambda cells: [*cells[:5], "10", "3000.0", "true", *cells[8:]]),
        (
            (
                f"{LOG}, row 2",
                "Column `return` is 3000.0; expected -200 to 200 in 10 steps of this task.",
                "Write the undiscounted, unscaled sum of the rewards.",
            ),
        ),
    ),
    Example(
        "foreign-fingerprint",
        "the fingerprint of other physics",
        cell(2, 9, "0123456789abcdef"),
        (
            (
                f"{LOG}, row 2",
                "Column `fingerprint` is '0123456789abcdef'; expected 'HALF' for "
                "gym_extensions/HopperGravityHalf-v0.",
                "Evaluate in this benchmark's environments, with the pinned versions of gymnasium and "
                "mujoco.",
            ),
        ),
    ),
    Example(
        "impossible-end",
        "termination in HalfCheetah",
        cell(2, 7, "true", "halfcheetah-gravity/sequential.csv"),
        (
            (
                "halfcheetah-gravity/sequential.csv, row 2",
                "Column `terminated` is true, but gym_extensions/HalfCheetahGravityHalf-v0 never terminates.",
                "Write false in `terminated` if the time limit ended the episode.",
            ),
        ),
        group="halfcheetah-gravity",
    ),
)


@parametrize(EXAMPLES)
def test_the_rule_reports_these_problems_and_no_other(example: Example, check: Check) -> None:
    check(example)


def test_thousands_of_bad_rows_are_counted_not_listed(submission: Callable[..., Path]) -> None:
    folder = submission()
    edit(",1000,", ",2000,", count=-1)(folder)
    found = [problem for problem in read(folder).problems if problem.rule == "impossible-length"]
    assert len(found) == 4
    assert found[-1].message == "1197 more rows of this file break the same rule."


@pytest.mark.parametrize("task", TASKS.values(), ids=lambda task: task.name)
def test_every_task_has_a_row_of_bounds(task: Task) -> None:
    assert task.body.rewards.low < task.body.rewards.high
