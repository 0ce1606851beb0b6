"""The cells of a submission that are evaluated again, with their policies and logged returns."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.protocol import EVALUATION_EPISODES
from gym_extensions.rollouts.auditing.sample import performance_cells
from gym_extensions.rollouts.folder import Folder
from gym_extensions.rollouts.reading.evaluation_log import Log
from gym_extensions.rollouts.submission import SubmittedGroup
from gym_extensions.scoring.replay.policy_files import has_policies, policy_path


@dataclass(frozen=True)
class Cell:
    """A cell: its log, run, stage and task, the path of its policy, and the logged returns."""

    protocol: str
    run: int
    stage: int
    task_index: int
    policy: str
    logged: NDArray[np.float64]


def cells_of(submitted: SubmittedGroup, folder: Folder) -> Iterator[Cell]:
    """R[T][j], R[j][j] and S[j] of every run of every log with policies (:func:`performance_cells`)."""
    for protocol, log in submitted.logs.items():
        if not has_policies(log, folder):
            continue
        returns = dict(_returns(log))
        for run in log.runs:
            for stage, task_id in performance_cells(protocol, log.group.tasks):
                index = log.group.task_ids.index(task_id)
                path = policy_path(log, run, stage, index)
                yield Cell(protocol, run, stage, index, path, returns[run, stage, index])


def _returns(log: Log) -> Iterator[tuple[tuple[int, int, int], NDArray[np.float64]]]:
    """The returns of each cell by run, stage and task. The rows of a log without problems are sorted."""
    for start in range(0, len(log.run), EVALUATION_EPISODES):
        key = int(log.run[start]), int(log.stage[start]), int(log.position[start])
        yield key, log.return_[start : start + EVALUATION_EPISODES]
