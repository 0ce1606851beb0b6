"""The rows of submissions' logs as data frames."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import pandas as pd

from gym_extensions.errors import BenchError
from gym_extensions.results.columns import select_columns
from gym_extensions.rollouts.folder import submission_folders
from gym_extensions.rollouts.reader import read
from gym_extensions.rollouts.submission import Submission

Paths = str | Path | Iterable[str | Path]

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
    "fingerprint": "str",
}
CURVE_DTYPES = {
    "submission": "str",
    "group": "str",
    "protocol": "str",
    "run": "int64",
    "task": "str",
    "step": "int64",
    "return": "float64",
}


def episodes(submissions: Paths, columns: Sequence[str] | None = None) -> pd.DataFrame:
    """Every evaluation episode, one per row, as logged (identical runs included).

    ======================  ===========================================================================
    column                  value
    ======================  ===========================================================================
    submission, group       folder name of the submission; group id
    protocol                ``sequential``, ``single`` or ``joint``
    run                     training seed
    stage                   number of tasks trained so far; 0 is untrained, 1 in single and joint logs
    task, episode           task id; number of the episode in its cell, from 0
    seed                    reset seed
    length                  environment steps
    return                  undiscounted sum of rewards
    terminated              whether the task ended the episode (otherwise the time limit did)
    fingerprint             fingerprint of the task
    ======================  ===========================================================================

    Args:
        submissions: a submission, a folder of submissions, or a list of these.
        columns: the columns to return, in this order; all by default.

    Raises:
        BenchError: a submission has problems, or there is no such column.
    """
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
                "fingerprint": log.fingerprint,
            }
        )
        for submission in _submissions(submissions)
        for group_id, group in submission.groups.items()
        for protocol, log in group.logs.items()
    ]
    return select_columns(_concat(frames, EPISODE_DTYPES), columns)


def curves(submissions: Paths, columns: Sequence[str] | None = None) -> pd.DataFrame:
    """Every point of the training curves, one per row.

    ==========================  =======================================================================
    column                      value
    ==========================  =======================================================================
    submission, group           folder name of the submission; group id
    protocol, run, task         which curve
    step                        training steps since the stage began (in joint logs: since the run began)
    return                      mean return of the training episodes that ended since the last point
    ==========================  =======================================================================

    Args and Raises are those of :func:`episodes`.
    """
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
        for submission in _submissions(submissions)
        for group_id, group in submission.groups.items()
        if group.curves is not None
    ]
    return select_columns(_concat(frames, CURVE_DTYPES), columns)


def as_paths(submissions: Paths) -> list[Path]:
    """The paths that an argument names."""
    return (
        [Path(submissions)] if isinstance(submissions, str | Path) else [Path(path) for path in submissions]
    )


def _submissions(submissions: Paths) -> Iterator[Submission]:
    for folder in submission_folders(as_paths(submissions)):
        submission = read(folder)
        if submission.problems:
            problem = submission.problems[0]
            message = f"The submission has {len(submission.problems)} problem(s). {problem.message}"
            raise BenchError("not-valid", message, problem.where, f"Run: score {folder}")
        yield submission


def _concat(frames: list[pd.DataFrame], dtypes: dict[str, str]) -> pd.DataFrame:
    empty = pd.DataFrame({name: pd.Series(dtype=dtype) for name, dtype in dtypes.items()})
    frame = pd.concat(frames, ignore_index=True) if frames else empty
    return frame.astype(dtypes)
