"""Evaluations of all tasks in the course of training as a data frame."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import pandas as pd

from gym_extensions.catalog.budgets import Budget
from gym_extensions.catalog.budgets import budget as budget_named
from gym_extensions.catalog.protocol import PROTOCOLS
from gym_extensions.results.columns import check_columns, concat, select_columns
from gym_extensions.results.submissions import CustomGroups, Paths, read_all
from gym_extensions.rollouts.submission import SubmittedGroup

EVALUATION_DTYPES = {
    "submission": "str",
    "group": "str",
    "protocol": "str",
    "run": "int64",
    "stage": "int64",
    "task": "str",
    "step": "int64",
    "trained": "float64",
    "episodes": "int64",
    "return": "float64",
}


def evaluations(
    submissions: Paths, columns: Sequence[str] | None = None, *, groups: CustomGroups = ()
) -> pd.DataFrame:
    """Every evaluation of a task, during training and after each stage, in the order of training.

    ===========  =======  ==========================================================================
    column       dtype    value
    ===========  =======  ==========================================================================
    submission   str      name of the submission's folder
    group        str      group id
    protocol     str      ``sequential``, ``single`` or ``joint``
    run          int64    training seed
    stage        int64    the stage in training; 0 before training
    task         str      id of the evaluated task
    step         int64    training steps since the stage began
    trained      float64  stages trained; 1.5 is halfway through the second stage
    episodes     int64    number of episodes
    return       float64  mean return of the episodes
    ===========  =======  ==========================================================================

    The rows during training are those of ``evaluations.csv``, which ``train(…, evaluate_every=…)`` writes.
    The rows after a stage are the means of the logs. Rows are sorted by group, protocol, run, step and task
    in training order.

    Args:
        submissions: a submission, a folder of submissions, or a list of these.
        columns: the columns to return, in this order; all by default.
        groups: custom groups that the submissions may contain: TOML files or TaskGroup objects.

    Raises:
        BenchError: a path does not exist, a submission has problems, a column is unknown, or a group is
            invalid.
    """
    check_columns(columns, EVALUATION_DTYPES)
    frames = [
        _frame(group, budget_named(submission.manifest.protocol.budget)).assign(
            submission=submission.name, group=group_id
        )[list(EVALUATION_DTYPES)]
        for submission in read_all(submissions, groups)
        if submission.manifest is not None
        for group_id, group in submission.groups.items()
    ]
    return select_columns(concat(frames, EVALUATION_DTYPES), columns)


def _frame(group: SubmittedGroup, budget: Budget) -> pd.DataFrame:
    """The evaluations of one group in the order of training."""
    steps = {
        protocol: budget.steps_for(group.group.name) * (len(group.group.tasks) if protocol == "joint" else 1)
        for protocol in PROTOCOLS
    }
    frame = pd.concat([*_after_stages(group, steps), *_during_training(group, steps)])
    orders = {"protocol": PROTOCOLS, "task": group.group.task_ids}
    indices = {name: {value: i for i, value in enumerate(order)} for name, order in orders.items()}
    return frame.sort_values(
        ["protocol", "run", "stage", "step", "task"],
        kind="stable",
        key=lambda column: column.map(indices[column.name]) if column.name in indices else column,
    )


def _after_stages(group: SubmittedGroup, steps: dict[str, int]) -> Iterator[pd.DataFrame]:
    for protocol, log in group.logs.items():
        rows = pd.DataFrame({"run": log.run, "stage": log.stage, "task": log.task, "return": log.return_})
        cells = rows.groupby(["run", "stage", "task"])["return"].agg(["size", "mean"]).reset_index()
        cells = cells.rename(columns={"size": "episodes", "mean": "return"})
        step = np.where(cells["stage"] > 0, steps[protocol], 0)
        yield cells.assign(protocol=protocol, step=step, trained=cells["stage"].astype("float64"))


def _during_training(group: SubmittedGroup, steps: dict[str, int]) -> Iterator[pd.DataFrame]:
    rows = group.evaluations
    if rows is None:
        return
    stage_steps = np.array([steps[protocol] for protocol in rows.protocol])
    columns = {"protocol": rows.protocol, "run": rows.run, "stage": rows.stage, "task": rows.task}
    columns |= {"step": rows.step, "episodes": rows.episodes, "return": rows.return_}
    frame = pd.DataFrame(columns).assign(trained=rows.stage - 1 + rows.step / stage_steps)
    counted = [run in group.logs[name].runs for name, run in zip(rows.protocol, rows.run, strict=True)]
    yield frame[counted]
