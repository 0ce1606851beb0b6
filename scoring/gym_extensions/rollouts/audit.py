"""Selects the audit sample, the episodes whose traces a submission must include, by the finished log.

The sample has one episode per cell R[T][j], R[j][j] and S[j] of every run. It catches mistakes. It does not
catch deliberate deception, because any change of the log selects another sample (docs/rollout-log.md).
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
    """(stage, task) of the audited cells of a run.

    A cell is repeated once per column that it belongs to.

    Sequential: R[T][j] and R[j][j]; R[T][T] is both and appears twice. Single and joint:
    each task at stage 1.
    """
    if protocol != "sequential":
        return [(1, task) for task in tasks]
    return [(len(tasks), task) for task in tasks] + [
        (stage, task) for stage, task in enumerate(tasks, start=1)
    ]


def without_success(log: bytes) -> bytes:
    """The bytes of a log without the column ``success``, the last but one.

    The cells follow from the replayed episodes, so a log has the same sample with and without them.
    """
    rows = (line.rsplit(b",", 2) for line in log.splitlines())
    return b"".join(b",".join((row[0], row[-1])) + b"\n" for row in rows)


def audit_sample(protocol: str, log: bytes, runs: Sequence[int], tasks: Sequence[Task]) -> list[Audited]:
    """The episodes of one log whose traces a submission must include, sorted.

    With D the hexadecimal SHA-256 of the log file's bytes without the column ``success``, the episodes of a
    cell are ranked by the SHA-256 of ``D/<run>/<stage>/<task id>/<episode>``, lowest first; a cell that
    appears n times gives its first n.

    Args:
        protocol: sequential, single or joint.
        log: the bytes of ``<protocol>.csv``.
        runs: the runs in it.
        tasks: the group's tasks, in training order.
    """
    digest = hashlib.sha256(without_success(log)).hexdigest()
    cells = audited_cells(protocol, tasks)
    sample = []
    for run in runs:
        for stage, task in dict.fromkeys(cells):

            def rank(episode: int, cell: str = f"{digest}/{run}/{stage}/{task.id}") -> str:
                return hashlib.sha256(f"{cell}/{episode}".encode()).hexdigest()

            ranked = sorted(range(EVALUATION_EPISODES), key=rank)
            count = cells.count((stage, task))
            sample += [Audited(run, stage, task.id, episode) for episode in ranked[:count]]
    return sorted(sample)
