"""Rules about curves.csv, the training curves."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.protocol import PROTOCOLS
from gym_extensions.errors import did_you_mean
from gym_extensions.rollouts.problem import MAX_QUOTE, Finding, quote, row_findings
from gym_extensions.rollouts.reading.training_curves import Curves, Key
from gym_extensions.rollouts.rules.rule import rule

BUDGET_TOLERANCE = 1.02
"""A curve may exceed the budget by 2 %, for an agent whose last batch exceeds it."""


def _rows(mask: NDArray[np.bool_]) -> list[int]:
    rows: list[int] = np.flatnonzero(mask).tolist()
    return rows


def _is_foreign(curves: Curves, key: Key) -> bool:
    protocol, run, task = key
    if protocol not in PROTOCOLS or task not in curves.group.task_ids:
        return True
    runs = curves.runs.get(protocol, ())
    return runs is not None and run not in runs


@rule("curves")
def foreign_curve(curves: Curves) -> Iterator[Finding]:
    """Every curve belongs to a task of the group and to a run of one of its logs."""
    members = curves.group.task_ids
    blocks = [block for block in curves.blocks if _is_foreign(curves, block[0])]
    rows = {row: key for key, start, stop in blocks for row in range(start, stop)}

    def message(row: int) -> str:
        protocol, run, task = rows[row]
        if protocol not in PROTOCOLS:
            return f"Unknown protocol {quote(protocol)}."
        if task not in members:
            return f"{quote(task)} is not a task of {curves.group.id}."
        return f"{protocol}.csv has no run {run}."

    hint = "Include only the curves of logged runs."
    first = next(iter(rows.values()), None)
    if first is not None and first[2] not in members:
        hint = did_you_mean(first[2][:MAX_QUOTE], members)
    yield from row_findings(curves.path, list(rows), message, hint, curves.numbers)


@rule("curves")
def curve_order(curves: Curves) -> Iterator[Finding]:
    """The rows of a curve are consecutive, and its steps increase from row to row, starting above 0."""
    late = np.diff(curves.step, prepend=0) <= 0
    keys = [key for key, _, _ in curves.blocks]
    last_row: dict[Key, int] = {}
    previous: Key | None = None
    for index, (key, start, stop) in enumerate(curves.blocks):
        if 0 < index < len(keys) - 1 and keys[index - 1] == keys[index + 1]:
            late[start] = not _is_foreign(curves, key)  # it interrupts a curve that continues after it
            continue
        continues = key == previous and curves.step[start] > curves.step[last_row[key]]
        late[start] = key in last_row and not continues
        last_row[key], previous = stop - 1, key
    hint = "Sort by protocol, run, task in training order and step; every curve counts its steps from 0."

    def message(row: int) -> str:
        return f"Step {curves.step[row]} does not follow the row above."

    rows = _rows(late | (curves.step < 1))
    yield from row_findings(curves.path, rows, message, hint, curves.numbers)


@rule("curves")
def curve_not_finite(curves: Curves) -> Iterator[Finding]:
    """Every return of a curve is a finite number."""

    def message(row: int) -> str:
        return f"Column `return` is {curves.return_[row]}; expected a finite number."

    hint = "Leave out rows in which no episode ended; find the cause of other NaN or infinite values."
    rows = _rows(~np.isfinite(curves.return_))
    yield from row_findings(curves.path, rows, message, hint, curves.numbers)


@rule("curves")
def impossible_curve_return(curves: Curves) -> Iterator[Finding]:
    """A return of a curve is within the bounds of the task's episode return (catalog/bodies)."""
    spans = {task.id: task.return_bounds for task in curves.group.tasks}
    lowest, highest = max(low for low, _ in spans.values()), min(high for _, high in spans.values())
    if ((curves.return_ >= lowest) & (curves.return_ <= highest)).all():
        return  # within the bounds of every task
    lower, upper = np.full((2, curves.step.size), [[-np.inf], [np.inf]])
    for (_, _, task), start, stop in curves.blocks:
        lower[start:stop], upper[start:stop] = spans.get(task, (-np.inf, np.inf))
    is_outside = np.isfinite(curves.return_) & ((curves.return_ < lower) | (curves.return_ > upper))

    def message(row: int) -> str:
        bounds = f"an episode of this task returns {lower[row]:g} to {upper[row]:g}"
        return f"Column `return` is {float(curves.return_[row])!r}; {bounds}."

    hint = "Write the mean of the undiscounted, unscaled returns of the episodes that ended."
    yield from row_findings(curves.path, _rows(is_outside), message, hint, curves.numbers)


@rule("curves")
def over_budget(curves: Curves) -> Iterator[Finding]:
    """No curve exceeds the budget's training steps by more than 2 % (the tolerance is for the last batch)."""
    if curves.budget is None:
        return
    name, steps = curves.budget.name, curves.budget.steps_for(curves.group.name)
    limit = np.full(curves.step.size, steps)
    for (protocol, _, _), start, stop in curves.blocks:
        limit[start:stop] = steps * (len(curves.group.tasks) if protocol == "joint" else 1)

    def message(row: int) -> str:
        return f"Step {curves.step[row]} exceeds the budget {name!r} of {limit[row]} steps."

    hint = "Train within the budget, or name the larger budget in submission.toml."
    rows = _rows(curves.step > BUDGET_TOLERANCE * limit)
    yield from row_findings(curves.path, rows, message, hint, curves.numbers)
