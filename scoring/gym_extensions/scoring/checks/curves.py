"""Rules about curves.csv, the training curves."""

from __future__ import annotations

import functools
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

from gym_extensions.catalog.errors import did_you_mean
from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.catalog.protocol import PROTOCOLS, Budget
from gym_extensions.scoring.checks.rule import rule
from gym_extensions.scoring.problems import Finding, told

SLACK = 1.02
"""A budget may be exceeded by 2 %, as far as an agent's last batch reaches."""


@dataclass(frozen=True)
class Curves:
    """The rows of curves.csv as columns; ``runs`` are those of each protocol's log."""

    path: str
    group: TaskGroup
    budget: Budget | None
    runs: dict[str, tuple[int, ...]]
    protocol: list[str]
    run: list[int]
    task: list[str]
    step: list[int]
    return_: list[float]

    @functools.cached_property
    def keys(self) -> list[tuple[str, int, str]]:
        """Protocol, run and task of each row: the curve it belongs to."""
        return list(zip(self.protocol, self.run, self.task, strict=True))


@rule("curves")
def foreign_curve(curves: Curves) -> Iterator[Finding]:
    """Every curve belongs to a task of the group and to a run of one of its logs."""
    members = set(curves.group.task_ids)
    known = {
        (protocol, run, task) for protocol, runs in curves.runs.items() for run in runs for task in members
    }
    rows = [index for index, key in enumerate(curves.keys) if key not in known]

    def say(index: int) -> str:
        protocol, run, task = curves.keys[index]
        if protocol not in PROTOCOLS:
            return f"There is no protocol {protocol!r}."
        if task not in members:
            return f"{task!r} is no task of {curves.group.id}."
        return f"{protocol}.csv has no run {run}."

    hint = "Keep the curves of the runs that are logged."
    if rows and curves.keys[rows[0]][2] not in members:
        hint = did_you_mean(curves.keys[rows[0]][2], members)
    yield from told(curves.path, rows, say, hint)


@rule("curves")
def curve_order(curves: Curves) -> Iterator[Finding]:
    """Within a curve the training steps grow from row to row, from 1 on; its rows stand together."""
    keys, steps = curves.keys, curves.step
    rows = [0] if steps and steps[0] < 1 else []
    seen = set(keys[:1])
    for here, (before, key) in enumerate(pairwise(keys), 1):
        late = steps[here] <= steps[here - 1] if key == before else key in seen
        if late or steps[here] < 1:
            rows.append(here)
        seen.add(key)
    say = "Step {} does not follow the row above.".format
    hint = "Sort by protocol, run, task in training order and step; steps count from 0 in every curve."
    yield from told(curves.path, rows, lambda index: say(curves.step[index]), hint)


@rule("curves")
def curve_not_finite(curves: Curves) -> Iterator[Finding]:
    """Every return of a curve is a finite number."""
    rows = [index for index, value in enumerate(curves.return_) if not abs(value) < float("inf")]
    hint = "Leave the row out where no episode ended; find the cause of NaN elsewhere."
    yield from told(curves.path, rows, lambda index: f"The return is {curves.return_[index]}.", hint)


@rule("curves")
def over_budget(curves: Curves) -> Iterator[Finding]:
    """No curve goes beyond the budget's training steps by more than 2 % (the last batch may reach over)."""
    if curves.budget is None:
        return
    steps = curves.budget.steps_for(curves.group.name)
    limits = {"joint": steps * len(curves.group.tasks)}
    rows = [i for i, step in enumerate(curves.step) if step > SLACK * limits.get(curves.protocol[i], steps)]
    budget = curves.budget.name

    def say(index: int) -> str:
        limit = limits.get(curves.protocol[index], steps)
        return f"Step {curves.step[index]} is beyond the budget {budget!r}, which is {limit} steps here."

    yield from told(
        curves.path, rows, say, "Train within the budget, or name the larger budget in submission.toml."
    )
