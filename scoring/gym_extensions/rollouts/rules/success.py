"""Rules about the column ``success`` of a log."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.bodies.success import Arrival
from gym_extensions.rollouts.problem import Finding, row_findings
from gym_extensions.rollouts.reading.evaluation_log import Log
from gym_extensions.rollouts.rules.rule import rule


def _defines(log: Log) -> NDArray[np.bool_]:
    """Whether the task of each row defines success; False for a task of another group."""
    return np.array([*(task.body.success is not None for task in log.group.tasks), False])[log.position]


@rule("log")
def missing_success(log: Log) -> Iterator[Finding]:
    """`success` is true or false in tasks that define success."""

    def message(index: int) -> str:
        return f"Column `success` is empty, but {log.task[index]} defines success."

    hint = 'Write info["is_success"] of the last step of the episode.'
    rows = np.flatnonzero((log.success < 0) & _defines(log)).tolist()
    yield from row_findings(log.path, rows, message, hint, log.numbers)


@rule("log")
def undefined_success(log: Log) -> Iterator[Finding]:
    """`success` is empty in tasks that define no success, such as the running tasks."""
    cells = ("false", "true")

    def message(index: int) -> str:
        return f"Column `success` is {cells[log.success[index]]}, but {log.task[index]} defines no success."

    rows = np.flatnonzero((log.success >= 0) & ~_defines(log) & (log.position >= 0)).tolist()
    yield from row_findings(log.path, rows, message, "Leave the cell empty.", log.numbers)


@rule("log")
def contradictory_success(log: Log) -> Iterator[Finding]:
    """Where success is the arrival at a goal, `success` equals `terminated`."""
    arrives = np.array([*(isinstance(task.body.success, Arrival) for task in log.group.tasks), False])
    cells = ("false", "true")

    def message(index: int) -> str:
        ended = cells[int(log.terminated[index])]
        return f"Column `success` is {cells[log.success[index]]}, but `terminated` is {ended}."

    hint = "This task ends at the goal, and only there: write the same value in both columns."
    is_contradictory = (log.success >= 0) & (log.success != log.terminated)
    rows = np.flatnonzero(is_contradictory & arrives[log.position]).tolist()
    yield from row_findings(log.path, rows, message, hint, log.numbers)
