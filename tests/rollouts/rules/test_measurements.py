"""Rules about what a log says was measured: cells, lengths, returns, ends, fingerprints."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from gym_extensions.catalog.registry import TASKS
from gym_extensions.catalog.task import Task
from gym_extensions.rollouts.reader import read

from .broken import LOG, Broken, Judge, cell, each, edit, row

COUNT_STEPS = "Count the steps from the reset to the end of the episode."

BROKEN = (
    Broken(
        "bad-cell",
        "a length with a point and a word for a return",
        lambda folder: cell(3, 5, "1000.0")(folder) or cell(4, 6, "many")(folder),
        (
            (f"{LOG}, row 3", "The length is '1000.0'.", "Write a whole number."),
            (f"{LOG}, row 4", "The return is 'many'.", "Write a number."),
        ),
    ),
    Broken(
        "bad-cell",
        "True in place of true",
        cell(3, 7, "True"),
        ((f"{LOG}, row 3", "The terminated is 'True'.", "Write true or false."),),
    ),
    Broken(
        "not-finite",
        "NaN and infinity",
        lambda folder: cell(2, 6, "nan")(folder) or cell(3, 6, "-inf")(folder),
        (
            (
                f"{LOG}, row 2",
                "The return is nan.",
                "Find what the policy or the sum did there; the row cannot be scored.",
            ),
            (
                f"{LOG}, row 3",
                "The return is -inf.",
                "Find what the policy or the sum did there; the row cannot be scored.",
            ),
        ),
    ),
    Broken(
        "impossible-length",
        "episodes that are too long, empty and negative",
        lambda folder: [
            cell(number, 5, steps)(folder) for number, steps in ((2, "1001"), (3, "0"), (4, "-5"))
        ],
        tuple(
            (
                f"{LOG}, row {number}",
                f"The length is {steps}; the task's episodes have 1 to 1000 steps.",
                COUNT_STEPS,
            )
            for number, steps in ((2, 1001), (3, 0), (4, -5))
        ),
    ),
    Broken(
        "unfinished-episode",
        "an episode that nobody ended",
        cell(2, 5, "999"),
        (
            (
                f"{LOG}, row 2",
                "The episode stops after 999 of 1000 steps and terminated is false.",
                "Evaluate every episode to its end; write terminated = true where the task ended it.",
            ),
        ),
    ),
    Broken(
        "impossible-return",
        "a return beyond what the task can give in that many steps",
        row(2, lambda cells: [*cells[:5], "10", "3000.0", "true", cells[8]]),
        (
            (
                f"{LOG}, row 2",
                "The return is 3000.0; 10 steps of this task give from -200 to 200.",
                "Write the undiscounted, unscaled sum of the rewards.",
            ),
        ),
    ),
    Broken(
        "foreign-fingerprint",
        "a task of other physics",
        cell(2, 8, "0123456789abcdef"),
        (
            (
                f"{LOG}, row 2",
                "The fingerprint is '0123456789abcdef'; gym_extensions/HopperGravityHalf-v0 has 'HALF'.",
                "Evaluate in this benchmark's environments, with the pinned versions of gymnasium and "
                "mujoco.",
            ),
        ),
    ),
    Broken(
        "impossible-end",
        "HalfCheetah said to have ended an episode",
        cell(2, 7, "true", "halfcheetah-gravity/sequential.csv"),
        (
            (
                "halfcheetah-gravity/sequential.csv, row 2",
                "gym_extensions/HalfCheetahGravityHalf-v0 never ends an episode by itself.",
                "Write terminated = false where the time limit ended the episode.",
            ),
        ),
        group="halfcheetah-gravity",
    ),
)


@each(BROKEN)
def test_a_broken_folder_breaks_its_rule_and_says_so(example: Broken, judge: Judge) -> None:
    judge(example)


def test_thousands_of_bad_rows_are_counted_not_listed(submission: Callable[..., Path]) -> None:
    folder = submission()
    edit(",1000,", ",2000,", count=-1)(folder)
    found = [problem for problem in read(folder).problems if problem.rule == "impossible-length"]
    assert len(found) == 4
    assert found[-1].message == "1197 more rows of this file break the same rule."


@pytest.mark.parametrize("task", TASKS.values(), ids=lambda task: task.name)
def test_every_task_has_a_row_of_bounds(task: Task) -> None:
    assert task.body.rewards.low < task.body.rewards.high
