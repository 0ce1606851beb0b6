"""Rules about curves.csv, the training curves."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.errors import did_you_mean
from gym_extensions.catalog.protocol import PROTOCOLS
from gym_extensions.scoring.checks.rule import rule
from gym_extensions.scoring.curves import Curves
from gym_extensions.scoring.problems import Finding, told

SLACK = 1.02
"""A budget may be exceeded by 2 %, as far as an agent's last batch reaches."""


def _rows(mask: NDArray[np.bool_]) -> list[int]:
    rows: list[int] = np.flatnonzero(mask).tolist()
    return rows


@rule("curves")
def foreign_curve(curves: Curves) -> Iterator[Finding]:
    """Every curve belongs to a task of the group and to a run of one of its logs."""
    members = set(curves.group.task_ids)
    known = {
        (protocol, run, task) for protocol, runs in curves.runs.items() for run in runs for task in members
    }
    foreign = {start: (key, stop) for key, start, stop in curves.blocks if key not in known}
    rows = {row: key for start, (key, stop) in foreign.items() for row in range(start, stop)}

    def say(row: int) -> str:
        protocol, run, task = rows[row]
        if protocol not in PROTOCOLS:
            return f"There is no protocol {protocol!r}."
        if task not in members:
            return f"{task!r} is no task of {curves.group.id}."
        return f"{protocol}.csv has no run {run}."

    hint = "Keep the curves of the runs that are logged."
    first = next(iter(rows.values()), None)
    if first is not None and first[2] not in members:
        hint = did_you_mean(first[2], members)
    yield from told(curves.path, list(rows), say, hint)


@rule("curves")
def curve_order(curves: Curves) -> Iterator[Finding]:
    """Within a curve the training steps grow from row to row, from 1 on; its rows stand together."""
    late = np.diff(curves.step, prepend=0) <= 0
    seen = set()
    for key, start, _ in curves.blocks:
        late[start] = key in seen
        seen.add(key)
    rows = _rows(late | (curves.step < 1))
    say = "Step {} does not follow the row above.".format
    hint = "Sort by protocol, run, task in training order and step; steps count from 0 in every curve."
    yield from told(curves.path, rows, lambda row: say(curves.step[row]), hint)


@rule("curves")
def curve_not_finite(curves: Curves) -> Iterator[Finding]:
    """Every return of a curve is a finite number."""
    rows = _rows(~np.isfinite(curves.return_))
    hint = "Leave the row out where no episode ended; find the cause of NaN elsewhere."
    yield from told(curves.path, rows, lambda row: f"The return is {curves.return_[row]}.", hint)


@rule("curves")
def over_budget(curves: Curves) -> Iterator[Finding]:
    """No curve goes beyond the budget's training steps by more than 2 % (the last batch may reach over)."""
    if curves.budget is None:
        return
    steps = curves.budget.steps_for(curves.group.name)
    limit = np.full(curves.step.size, steps)
    for (protocol, _, _), start, stop in curves.blocks:
        limit[start:stop] = steps * (len(curves.group.tasks) if protocol == "joint" else 1)
    budget = curves.budget.name

    def say(row: int) -> str:
        return f"Step {curves.step[row]} is beyond the budget {budget!r}, which is {limit[row]} steps here."

    hint = "Train within the budget, or name the larger budget in submission.toml."
    yield from told(curves.path, _rows(curves.step > SLACK * limit), say, hint)
