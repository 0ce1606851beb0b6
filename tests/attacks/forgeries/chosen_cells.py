"""Invents returns of some cells of sequential.csv, of which the audit sample has few episodes.

The cells R[s][j] with 0 < s < j are evaluated after some training, and before that on the task. Of the runs
from 2 on, one episode per stage is drawn of all cells together, in place of the largest return of its cell.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from gym_extensions.curation.salt import derive_salt
from gym_extensions.rollouts.auditing.sample import RUNS_WITH_DRAWS_PER_CELL, Audited, audit_sample
from gym_extensions.rollouts.auditing.submission_digest import submission_digest

from ..forger import Forger, Row, cells, largest
from ..judge import MERGE, Make
from ..workshop import Workshop

Choice = Callable[[Forger, Sequence[Row]], list[list[Row]]]
"""The rows of the cells to change, of those of sequential.csv."""


def sequential(choose: Choice, edit: Callable[[Forger, list[Row]], object]) -> Make:
    """Changes the chosen cells, and commits to the result."""

    def make(workshop: Workshop) -> Path:
        forger = Forger(workshop.copy("linear"))
        rows = forger.rows("sequential")
        for cell in choose(forger, rows):
            edit(forger, cell)
        forger.write(rows, "sequential")
        return forger.commit()

    return make


def before_training(forger: Forger, rows: Sequence[Row]) -> list[list[Row]]:
    """The cells R[s][j] with 0 < s < j."""
    task_ids = forger.group.task_ids
    return [cell for cell in cells(rows) if 0 < int(cell[0]["stage"]) < task_ids.index(cell[0]["task"]) + 1]


def later_runs(forger: Forger, rows: Sequence[Row]) -> list[list[Row]]:
    """The cells R[s][s] and R[T][j] of the runs from 2 on."""
    task_ids = forger.group.task_ids
    return [
        cell
        for cell in cells(rows)
        if int(cell[0]["run"]) >= RUNS_WITH_DRAWS_PER_CELL
        and int(cell[0]["stage"]) in {task_ids.index(cell[0]["task"]) + 1, len(task_ids)}
    ]


def later_ends(forger: Forger, rows: Sequence[Row]) -> list[list[Row]]:
    """The cells R[T][1] of the runs from 2 on."""
    stage, task_id = str(len(forger.group.task_ids)), forger.group.task_ids[0]
    return [
        cell for cell in later_runs(forger, rows) if cell[0]["stage"] == stage and cell[0]["task"] == task_id
    ]


def missed(choose: Choice, count: int, above: float = -1e-3) -> Make:
    """Invents some of 20 episodes of the cells; digits are changed until the judge's samples have none.

    The invented returns are those of the cell's largest and ``above`` more. An author can do so for the
    sample without a salt. That of the salt misses them by chance.
    """

    def make(workshop: Workshop) -> Path:
        forger = Forger(workshop.copy("linear"))
        rows = forger.rows("sequential")
        invented: list[tuple[Row, float]] = []
        for cell in choose(forger, rows):
            return_ = largest(cell) + above
            lowest = sorted(cell, key=lambda row: float(row["return"]))[:count]
            invented += [(row, return_) for row in lowest]
        for row, return_ in invented:
            forger.lose(row, return_, "sequential")
        for attempt in range(1000):
            for row, return_ in invented:
                row["return"] = repr(return_ - attempt * 1e-9)
            forger.write(rows, "sequential")
            folder = forger.commit()
            salt = derive_salt(submission_digest(folder), MERGE)
            if all(forger.stored(row, "sequential").exists() for row in sampled(forger, rows, salt)):
                return folder
        raise AssertionError("The samples of 1000 logs all have an invented episode.")

    return make


def sampled(forger: Forger, rows: Sequence[Row], salt: str) -> list[Row]:
    """The rows of sequential.csv that are in the sample without a salt or in that of the salt."""
    log, tasks = forger.log("sequential").read_bytes(), forger.group.tasks
    runs = sorted({int(row["run"]) for row in rows})
    sample = {item for each in ("", salt) for item in audit_sample("sequential", log, runs, tasks, each)}

    def key(row: Row) -> Audited:
        return Audited(int(row["run"]), int(row["stage"]), row["task"], int(row["episode"]))

    return [row for row in rows if key(row) in sample]


def all_above(forger: Forger, cell: list[Row]) -> None:
    top = largest(cell)
    for row in cell:
        forger.lose(row, top + 5.0, "sequential")


def all_but_largest(forger: Forger, cell: list[Row]) -> None:
    top = largest(cell)
    for row in cell:
        if float(row["return"]) < top:
            forger.lose(row, top - 1e-3, "sequential")
