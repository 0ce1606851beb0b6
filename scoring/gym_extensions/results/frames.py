"""Rows of submissions as data frames: episodes, training curves and evaluations."""

import inspect
import re
from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np
import pandas as pd

from gym_extensions.catalog.groups import Groups, with_custom
from gym_extensions.catalog.protocol import PROTOCOLS, budget
from gym_extensions.scoring.output.board_frames import typed
from gym_extensions.scoring.pipeline import Paths, find_submissions
from gym_extensions.submissions.problem import refuse_problems
from gym_extensions.submissions.reader import read
from gym_extensions.submissions.run import stage_steps
from gym_extensions.submissions.submission import Submission, SubmittedGroup, scored_group


def read_groups(submissions: Paths, groups: Groups) -> Iterator[tuple[Submission, SubmittedGroup]]:
    """The submissions in order of their names, with each of their groups and its scored runs.

    Raises ``BenchError`` if a submission has problems or is missing.
    """
    known = with_custom(groups)
    for folder in find_submissions(submissions):
        submission = read(folder, known)
        refuse_problems(folder, submission.problems)
        for submitted in submission.shown_groups.values():
            yield submission, scored_group(submitted)


def columns_of(function: Callable[..., pd.DataFrame]) -> list[tuple[str, str, str]]:
    """Name, dtype and value of every column, from the table in the docstring of a function of results."""
    docstring = (inspect.getdoc(function) or "").replace("``", "`")
    text = re.split(r"^=+(?: +=+)+$\n?", docstring, flags=re.MULTILINE)[2]
    rows = [re.split(r" {2,}", line, maxsplit=2) for line in text.splitlines()]
    return [(column.strip("`"), dtype, value) for column, dtype, value in rows]


def dtypes_of(function: Callable[..., pd.DataFrame]) -> dict[str, str]:
    """The dtype of every column, from the same table; a row may name several columns."""
    return {name: dtype for names, dtype, _ in columns_of(function) for name in names.split(", ")}


def concat(frames: Sequence[pd.DataFrame], dtypes: Mapping[str, str]) -> pd.DataFrame:
    """The frames below each other, with these columns and dtypes also without rows."""
    return typed(pd.concat(frames, ignore_index=True)[list(dtypes)] if frames else (), dtypes)


def episodes(submissions: Paths, *, groups: Groups = ()) -> pd.DataFrame:
    """Every evaluation episode, one per row, in the order of the logs.

    ===========  =======  ==========================================================================
    column       dtype    value
    ===========  =======  ==========================================================================
    submission   str      name of the submission's folder
    group        str      group id
    protocol     str      ``sequential``, ``single`` or another one (docs/concepts.md)
    run          int64    training seed
    stage        int64    number of tasks trained so far: 0 untrained; 1 in the other protocols
    task         str      task id
    episode      int64    number of the episode in its run, stage and task, from 0
    seed         int64    reset seed
    length       int64    environment steps
    return       float64  undiscounted sum of rewards
    terminated   bool     whether the task ended the episode; False where the time limit did
    success      boolean  whether the episode succeeded; missing where the task defines no success
    fingerprint  str      fingerprint of the task
    ===========  =======  ==========================================================================

    Of a group and protocol in which the project trained the code, they are its runs and not the author's own.
    Reported submissions have no episodes.

    Args:
        submissions: a submission, a folder of submissions, or a list of these.
        groups: custom groups that the submissions may contain: TOML files or TaskGroup objects.

    Raises:
        BenchError: a path does not exist, a submission has problems, or a group is invalid.
    """
    frames = [
        log.rows.assign(
            submission=submission.name,
            group=submitted.group.id,
            protocol=protocol,
            success=log.rows["success"].astype("Int8").where(log.rows["success"] >= 0),
            fingerprint=[
                submitted.runs[protocol][run].fingerprints[task]
                for run, task in zip(log.rows["run"], log.rows["task"], strict=True)
            ],
        )
        for submission, submitted in read_groups(submissions, groups)
        for protocol, log in submitted.logs.items()
    ]
    return concat(frames, dtypes_of(episodes))


def curves(submissions: Paths, *, groups: Groups = ()) -> pd.DataFrame:
    """Every point of the training curves, one per row, by protocol, run and task.

    ===========  =======  ==========================================================================
    column       dtype    value
    ===========  =======  ==========================================================================
    submission   str      name of the submission's folder
    group        str      group id
    protocol     str      ``sequential``, ``single`` or another one (docs/concepts.md)
    run          int64    training seed
    task         str      task id
    step         int64    training steps since the stage began
    return       float64  mean return of the training episodes that ended since the point before
    ===========  =======  ==========================================================================

    Runs without curves have no rows. The arguments and errors are those of :func:`episodes`.
    """
    rows = (
        (submission.name, submitted.group.id, protocol, run, curve.task, step, value)
        for submission, submitted in read_groups(submissions, groups)
        for protocol, log in submitted.logs.items()
        for run in log.runs
        for curve in submitted.runs[protocol][run].curves
        for step, value in zip(curve.steps, curve.returns, strict=True)
    )
    return typed(rows, dtypes_of(curves))


def evaluations(submissions: Paths, *, groups: Groups = ()) -> pd.DataFrame:
    """Every evaluation of a task, during training and after each stage, in the order of training.

    ===========  =======  ==========================================================================
    column       dtype    value
    ===========  =======  ==========================================================================
    submission   str      name of the submission's folder
    group        str      group id
    protocol     str      ``sequential``, ``single`` or another one (docs/concepts.md)
    run          int64    training seed
    stage        int64    the stage in training; 0 before training
    task         str      id of the evaluated task
    step         int64    training steps since the stage began
    trained      float64  stages trained; 1.5 is halfway through the second stage
    episodes     int64    number of episodes
    return       float64  mean return of the episodes
    ===========  =======  ==========================================================================

    The rows during training are those that ``train(…, evaluate_every=…)`` writes.
    The rows after a stage are the means of the logs. Rows are sorted by group, protocol, run, step and task
    in training order. The arguments and errors are those of :func:`episodes`.
    """
    frames = [
        _evaluations_of(submission, submitted).assign(submission=submission.name, group=submitted.group.id)
        for submission, submitted in read_groups(submissions, groups)
    ]
    return concat(frames, dtypes_of(evaluations))


def _evaluations_of(submission: Submission, submitted: SubmittedGroup) -> pd.DataFrame:
    steps = {
        protocol: stage_steps(budget(source.manifest.protocol.budget), submitted.group, protocol)
        for source in submission.sources
        if source.manifest and submitted.group.id in source.groups
        for protocol in source.groups[submitted.group.id].logs
    }
    parts = []
    for protocol, log in submitted.logs.items():
        cells = log.rows.groupby(["run", "stage", "task"])["return"].agg(["size", "mean"]).reset_index()
        cells = cells.rename(columns={"size": "episodes", "mean": "return"})
        step = np.where(cells["stage"] > 0, steps[protocol], 0)
        parts.append(cells.assign(protocol=protocol, step=step, trained=cells["stage"].astype("float64")))
    rows = [
        (protocol, run, part.stage, part.task, step, part.episodes, value)
        for protocol, log in submitted.logs.items()
        for run in log.runs
        for part in submitted.runs[protocol][run].evaluations
        for step, value in zip(part.steps, part.returns, strict=True)
    ]
    columns = ["protocol", "run", "stage", "task", "step", "episodes", "return"]
    during = pd.DataFrame(rows, columns=columns)
    parts.append(during.assign(trained=during["stage"] - 1 + during["step"] / during["protocol"].map(steps)))
    orders = {"protocol": PROTOCOLS, "task": submitted.group.task_ids}
    indices = {name: {value: i for i, value in enumerate(order)} for name, order in orders.items()}
    return pd.concat([part for part in parts if not part.empty]).sort_values(
        ["protocol", "run", "stage", "step", "task"],
        kind="stable",
        key=lambda column: column.map(indices[column.name]) if column.name in indices else column,
    )
