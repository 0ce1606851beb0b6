"""The rows of submissions' logs as data frames."""

from __future__ import annotations

from collections.abc import Sequence

import pandas as pd

from gym_extensions.results.columns import CURVE_DTYPES, check_columns, concat, select_columns
from gym_extensions.results.submissions import CustomGroups, Paths, read_all

EPISODE_DTYPES = {
    "submission": "str",
    "group": "str",
    "protocol": "str",
    "run": "int64",
    "stage": "int64",
    "task": "str",
    "episode": "int64",
    "seed": "int64",
    "length": "int64",
    "return": "float64",
    "terminated": "bool",
    "success": "boolean",
    "fingerprint": "str",
}


def episodes(
    submissions: Paths, columns: Sequence[str] | None = None, *, groups: CustomGroups = ()
) -> pd.DataFrame:
    """Every evaluation episode, one per row, in the order of the logs.

    ===========  =======  ==========================================================================
    column       dtype    value
    ===========  =======  ==========================================================================
    submission   str      name of the submission's folder
    group        str      group id
    protocol     str      ``sequential``, ``single`` or ``joint``
    run          int64    training seed
    stage        int64    number of tasks trained so far: 0 untrained; 1 in single and joint logs
    task         str      task id
    episode      int64    number of the episode in its run, stage and task, from 0
    seed         int64    reset seed
    length       int64    environment steps
    return       float64  undiscounted sum of rewards
    terminated   bool     whether the task ended the episode; False where the time limit did
    success      boolean  whether the episode succeeded; missing where the task defines no success
    fingerprint  str      fingerprint of the task
    ===========  =======  ==========================================================================

    Identical runs of an agent without parameters appear once, as they count once in scores. Reported
    entries have no episodes.

    Args:
        submissions: a submission, a folder of submissions, or a list of these.
        columns: the columns to return, in this order; all by default.
        groups: custom groups that the submissions may contain: TOML files or TaskGroup objects.

    Raises:
        BenchError: a path does not exist, a submission has problems, a column is unknown, or a group is
            invalid.
    """
    check_columns(columns, EPISODE_DTYPES)
    frames = [
        pd.DataFrame(
            {
                "submission": submission.name,
                "group": group_id,
                "protocol": protocol,
                "run": log.run,
                "stage": log.stage,
                "task": log.task,
                "episode": log.episode,
                "seed": log.seed,
                "length": log.length,
                "return": log.return_,
                "terminated": log.terminated,
                "success": pd.arrays.BooleanArray(log.success == 1, log.success < 0),
                "fingerprint": log.fingerprint,
            }
        )
        for submission in read_all(submissions, groups)
        for group_id, group in submission.groups.items()
        for protocol, log in group.logs.items()
    ]
    return select_columns(concat(frames, EPISODE_DTYPES), columns)


def curves(
    submissions: Paths, columns: Sequence[str] | None = None, *, groups: CustomGroups = ()
) -> pd.DataFrame:
    """Every point of the training curves, one per row, in the order of the files.

    ===========  =======  ==========================================================================
    column       dtype    value
    ===========  =======  ==========================================================================
    submission   str      name of the submission's folder
    group        str      group id
    protocol     str      ``sequential``, ``single`` or ``joint``
    run          int64    training seed
    task         str      task id
    step         int64    training steps since the stage began; in joint runs since the run began
    return       float64  mean return of the training episodes that ended since the point before
    ===========  =======  ==========================================================================

    Submissions without ``curves.csv`` have no rows. The curves of unfinished runs are in
    :func:`unfinished_curves`.

    Args:
        submissions: a submission, a folder of submissions, or a list of these.
        columns: the columns to return, in this order; all by default.
        groups: custom groups that the submissions may contain: TOML files or TaskGroup objects.

    Raises:
        BenchError: a path does not exist, a submission has problems, a column is unknown, or a group is
            invalid.
    """
    check_columns(columns, CURVE_DTYPES)
    frames = [
        pd.DataFrame(
            {
                "submission": submission.name,
                "group": group_id,
                "protocol": group.curves.protocol,
                "run": group.curves.run,
                "task": group.curves.task,
                "step": group.curves.step,
                "return": group.curves.return_,
            }
        )
        for submission in read_all(submissions, groups)
        for group_id, group in submission.groups.items()
        if group.curves is not None
    ]
    return select_columns(concat(frames, CURVE_DTYPES), columns)
