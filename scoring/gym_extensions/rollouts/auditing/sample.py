"""Selects the audit sample, the episodes whose traces a submission must include.

A run's own rows and a salt draw episodes. The sample of runs 0 and 1 has the episode with the largest return
of every cell, one drawn episode of each of the cells right after the training on a task and after the last
stage, and one per stage of its other cells together. The sample of later runs has one episode per cell: of
each stage one drawn episode, and of its other cells the one with the largest return.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass

from gym_extensions.catalog.protocol import EVALUATION_EPISODES
from gym_extensions.catalog.task import Task

RUNS_WITH_DRAWS_PER_CELL = 2
"""The runs 0 and 1 have one drawn episode of each cell of :func:`performance_cells`."""

TOGETHER = ""
"""In place of a task: the cells of a stage that have one drawn episode together."""


@dataclass(frozen=True, order=True)
class Audited:
    """One episode of the sample."""

    run: int
    stage: int
    task: str
    episode: int


def performance_cells(protocol: str, tasks: Sequence[Task]) -> list[tuple[int, str]]:
    """(stage, task id) of the cells of final performance and forgetting.

    Sequential: R[T][j] and R[j][j]. Single and joint: every task at stage 1.
    """
    if protocol != "sequential":
        return [(1, task.id) for task in tasks]
    last = [(len(tasks), task.id) for task in tasks]
    return list(dict.fromkeys([*last, *((stage, task.id) for stage, task in enumerate(tasks, start=1))]))


def audit_sample(
    protocol: str, log: bytes, runs: Sequence[int], tasks: Sequence[Task], salt: str = ""
) -> list[Audited]:
    """The episodes of one log whose traces a submission must include, sorted.

    Of every cell, the episode with the largest return, the first of several. Of the other episodes, in runs 0
    and 1 one of each cell of :func:`performance_cells` and one per stage of all other cells together, in
    later runs one per stage of all its cells together, which takes the place of the largest of its cell. It
    is the one whose SHA-256 of ``D/<salt>/<run>/<stage>/<task id>/<episode>`` is lowest, with D the
    hexadecimal SHA-256 of the run's rows; without a salt, of ``D/<run>/…``.

    Args:
        protocol: sequential, single or joint.
        log: the bytes of ``<protocol>.csv``, without problems.
        runs: runs in it; identical runs that count as one are left out.
        tasks: the group's tasks, in training order.
        salt: 64 hexadecimal digits, or empty.
    """
    header, *lines = log.decode().splitlines()
    columns = header.split(",")
    where = [columns.index(name) for name in ("run", "stage", "task", "return")]
    rows: dict[int, list[str]] = {run: [] for run in runs}
    returns: dict[tuple[int, int, str], list[float]] = {}
    for line in lines:
        cells = line.split(",")
        number, stage_number, task_id, return_ = (cells[index] for index in where)
        if int(number) in rows:
            rows[int(number)].append(line)
            returns.setdefault((int(number), int(stage_number), task_id), []).append(float(return_))
    seeds = {run: _seed(run_rows, salt) for run, run_rows in rows.items()}
    drawn = set(performance_cells(protocol, tasks))
    largest, pools = dict[tuple[int, int, str], Audited](), dict[tuple[int, int, str], list[Audited]]()
    for (run, stage, task), values in returns.items():
        best = values.index(max(values))
        largest[run, stage, task] = Audited(run, stage, task, best)
        has_own_draw = run < RUNS_WITH_DRAWS_PER_CELL and (stage, task) in drawn
        pool = pools.setdefault((run, stage, task if has_own_draw else TOGETHER), [])
        pool += [Audited(run, stage, task, each) for each in range(EVALUATION_EPISODES) if each != best]
    draws = [min(pool, key=lambda each: _rank(seeds[each.run], each)) for pool in pools.values()]
    for each in draws:
        if each.run >= RUNS_WITH_DRAWS_PER_CELL:
            del largest[each.run, each.stage, each.task]
    return sorted([*largest.values(), *draws])


def _seed(rows: Sequence[str], salt: str) -> str:
    digest = hashlib.sha256("".join(f"{row}\n" for row in rows).encode()).hexdigest()
    return f"{digest}/{salt}" if salt else digest


def _rank(seed: str, each: Audited) -> str:
    key = f"{seed}/{each.run}/{each.stage}/{each.task}/{each.episode}"
    return hashlib.sha256(key.encode()).hexdigest()
