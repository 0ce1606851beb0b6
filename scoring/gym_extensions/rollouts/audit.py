"""Selects the audit sample, the episodes whose traces a submission must include.

The sample has one episode per cell R[T][j], R[j][j] and S[j] of every run, and a run's own rows select it. It
catches mistakes. It does not catch deliberate deception, because any change of the rows selects another
sample (docs/rollout-log.md).
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from gym_extensions.catalog.protocol import EVALUATION_EPISODES
from gym_extensions.catalog.task import Task

AUDITED_COLUMNS = ("run", "stage", "task", "episode", "seed", "length", "return", "terminated", "fingerprint")
"""The columns that select the sample. A log may have more; they leave the sample as it is."""


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


def audit_sample(protocol: str, log: bytes, runs: Sequence[int], tasks: Sequence[Task]) -> list[Audited]:
    """The episodes of one log whose traces a submission must include, sorted.

    With D the hexadecimal SHA-256 of a run's rows, the episodes of a cell are ranked by the SHA-256
    of ``D/<run>/<stage>/<task id>/<episode>``, lowest first; a cell that appears n times gives its first n.

    Args:
        protocol: sequential, single or joint.
        log: the bytes of ``<protocol>.csv``.
        runs: runs in it; identical runs that count as one are left out.
        tasks: the group's tasks, in training order.
    """
    rows: dict[int, list[str]] = {run: [] for run in runs}
    for line in _audited_lines(log)[1:]:
        run = int(line.partition(",")[0])
        if run in rows:
            rows[run].append(line)
    return _draw(protocol, {run: _digest(lines) for run, lines in rows.items()}, tasks)


def whole_log_sample(protocol: str, log: bytes, runs: Sequence[int], tasks: Sequence[Task]) -> list[Audited]:
    """The sample as it was drawn before ADR 67, with D the digest of the whole log for every run.

    Logs that were recorded then have the traces of this sample.
    """
    return _draw(protocol, dict.fromkeys(runs, _digest(_audited_lines(log))), tasks)


def _audited_lines(log: bytes) -> list[str]:
    """The lines of a log, the header included, with the audited columns only."""
    lines = log.decode().splitlines()
    header = lines[0].split(",")
    if tuple(header) == AUDITED_COLUMNS:
        return lines
    columns = [header.index(name) for name in AUDITED_COLUMNS]
    return [",".join([cells[column] for column in columns]) for cells in (line.split(",") for line in lines)]


def _digest(lines: Iterable[str]) -> str:
    return hashlib.sha256("".join(f"{line}\n" for line in lines).encode()).hexdigest()


def _draw(protocol: str, digests: Mapping[int, str], tasks: Sequence[Task]) -> list[Audited]:
    cells = audited_cells(protocol, tasks)
    sample = []
    for run, digest in digests.items():
        for stage, task in dict.fromkeys(cells):

            def rank(episode: int, cell: str = f"{digest}/{run}/{stage}/{task.id}") -> str:
                return hashlib.sha256(f"{cell}/{episode}".encode()).hexdigest()

            ranked = sorted(range(EVALUATION_EPISODES), key=rank)
            count = cells.count((stage, task))
            sample += [Audited(run, stage, task.id, episode) for episode in ranked[:count]]
    return sorted(sample)
