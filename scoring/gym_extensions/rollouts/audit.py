"""Which episodes a submission must show: an audit sample that the finished log itself chooses.

One episode of every cell R[T][j], R[j][j] and S[j] of every run. It catches mistakes. Any change of the log
chooses anew, so that an author who means to deceive can try until it suits (docs/rollout-log.md).
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass

from gym_extensions.catalog.protocol import EVALUATION_EPISODES
from gym_extensions.catalog.task import Task


@dataclass(frozen=True, order=True)
class Audited:
    """One episode of the sample."""

    run: int
    stage: int
    task: str
    episode: int


def audited_cells(protocol: str, tasks: Sequence[Task]) -> list[tuple[int, Task]]:
    """(stage, task) of every audited cell of a run, once for every column of the table that it stands in.

    Sequential: R[T][j] and R[j][j]; R[T][T] is both and stands twice. Single and joint: each task at stage 1.
    """
    if protocol != "sequential":
        return [(1, task) for task in tasks]
    return [(len(tasks), task) for task in tasks] + [
        (stage, task) for stage, task in enumerate(tasks, start=1)
    ]


def audit_sample(protocol: str, log: bytes, runs: Sequence[int], tasks: Sequence[Task]) -> list[Audited]:
    """The episodes whose traces a submission holds for one log, sorted.

    With D the hexadecimal sha256 of the log file's bytes, the episodes of a cell are ranked by the sha256 of
    ``D/<run>/<stage>/<task id>/<episode>``, lowest first; a cell that stands n times gives its first n.

    Args:
        protocol: which log.
        log: the bytes of ``<protocol>.csv``.
        runs: the runs in it.
        tasks: the group's, in order.
    """
    digest = hashlib.sha256(log).hexdigest()
    cells = audited_cells(protocol, tasks)
    found = []
    for run in runs:
        for stage, task in dict.fromkeys(cells):

            def rank(episode: int, cell: str = f"{digest}/{run}/{stage}/{task.id}") -> str:
                return hashlib.sha256(f"{cell}/{episode}".encode()).hexdigest()

            ranked = sorted(range(EVALUATION_EPISODES), key=rank)
            found += [
                Audited(run, stage, task.id, episode) for episode in ranked[: cells.count((stage, task))]
            ]
    return sorted(found)
