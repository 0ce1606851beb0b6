"""Rules about curves.csv, the training curves."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.protocol import PROTOCOLS
from gym_extensions.errors import did_you_mean
from gym_extensions.rollouts.problem import LONGEST_QUOTE, Finding, shown, told
from gym_extensions.rollouts.reading.training_curves import Curves, Key
from gym_extensions.rollouts.rules.rule import rule

SLACK = 1.02
"""A budget may be exceeded by 2 %, as far as an agent's last batch reaches."""


def _rows(mask: NDArray[np.bool_]) -> list[int]:
    rows: list[int] = np.flatnonzero(mask).tolist()
    return rows


def _foreign(curves: Curves, key: Key) -> bool:
    protocol, run, task = key
    runs = curves.runs.get(protocol, ())
    known = protocol in PROTOCOLS and task in curves.group.task_ids
    return not known or (runs is not None and run not in runs)


@rule("curves")
def foreign_curve(curves: Curves) -> Iterator[Finding]:
    """Every curve belongs to a task of the group and to a run of one of its logs."""
    members = curves.group.task_ids
    blocks = [block for block in curves.blocks if _foreign(curves, block[0])]
    rows = {row: key for key, start, stop in blocks for row in range(start, stop)}

    def say(row: int) -> str:
        protocol, run, task = rows[row]
        if protocol not in PROTOCOLS:
            return f"There is no protocol {shown(protocol)}."
        if task not in members:
            return f"{shown(task)} is no task of {curves.group.id}."
        return f"{protocol}.csv has no run {run}."

    hint = "Keep the curves of the runs that are logged."
    first = next(iter(rows.values()), None)
    if first is not None and first[2] not in members:
        hint = did_you_mean(first[2][:LONGEST_QUOTE], members)
    yield from told(curves.path, list(rows), say, hint, curves.numbers)


@rule("curves")
def curve_order(curves: Curves) -> Iterator[Finding]:
    """Within a curve the training steps grow from row to row, from 1 on; its rows stand together."""
    late = np.diff(curves.step, prepend=0) <= 0
    keys = [key for key, _, _ in curves.blocks]
    last: dict[Key, int] = {}
    present: Key | None = None
    for place, (key, start, stop) in enumerate(curves.blocks):
        if 0 < place < len(keys) - 1 and keys[place - 1] == keys[place + 1]:
            late[start] = not _foreign(curves, key)  # it stands inside a curve that goes on after it
            continue
        late[start] = key in last and (key != present or curves.step[start] <= curves.step[last[key]])
        last[key], present = stop - 1, key
    rows = _rows(late | (curves.step < 1))
    say = "Step {} does not follow the row above.".format
    hint = "Sort by protocol, run, task in training order and step; steps count from 0 in every curve."
    yield from told(curves.path, rows, lambda row: say(curves.step[row]), hint, curves.numbers)


@rule("curves")
def curve_not_finite(curves: Curves) -> Iterator[Finding]:
    """Every return of a curve is a finite number."""
    rows = _rows(~np.isfinite(curves.return_))
    hint = "Leave the row out where no episode ended; find the cause of NaN elsewhere."
    yield from told(
        curves.path, rows, lambda row: f"The return is {curves.return_[row]}.", hint, curves.numbers
    )


@rule("curves")
def impossible_curve_return(curves: Curves) -> Iterator[Finding]:
    """A return of a curve lies within what the task can give in a whole episode (scoring/bounds.py)."""
    spans = {task.id: task.return_bounds for task in curves.group.tasks}
    lowest, highest = max(low for low, _ in spans.values()), min(high for _, high in spans.values())
    if ((curves.return_ >= lowest) & (curves.return_ <= highest)).all():
        return  # within the bounds of every task
    least, most = np.full((2, curves.step.size), [[-np.inf], [np.inf]])
    for (_, _, task), start, stop in curves.blocks:
        least[start:stop], most[start:stop] = spans.get(task, (-np.inf, np.inf))
    finite = np.isfinite(curves.return_)
    rows = _rows(finite & ((curves.return_ < least) | (curves.return_ > most)))

    def say(row: int) -> str:
        allowed = f"an episode of this task gives from {least[row]:g} to {most[row]:g}"
        return f"The return is {float(curves.return_[row])!r}; {allowed}."

    hint = "Write the mean of the undiscounted, unscaled returns of the episodes that ended."
    yield from told(curves.path, rows, say, hint, curves.numbers)


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
    yield from told(curves.path, _rows(curves.step > SLACK * limit), say, hint, curves.numbers)
