"""Checked logs -> raw returns -> runs with returns normalized between floor and expert."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.catalog.protocol import BUDGETS, EVALUATION_EPISODES, IN_ORDER, stages, task_order
from gym_extensions.metrics.formulas import NormalizedRun, area
from gym_extensions.references import References
from gym_extensions.submissions.submission import SubmittedGroup

Cells = list[list[list[list[float]]]]
Means = list[list[list[float]]]
Points = tuple[list[int], list[float]]
"""A training curve: steps, and the mean return of the training episodes that ended since the point before."""


@dataclass(frozen=True)
class GroupReturns:
    """Raw returns of a group.

    Attributes:
        group: the group.
        steps: the budget's training steps per task.
        runs: training seeds by protocol.
        returns: by protocol, [run][stage][task][episode]. Logs of one stage have one row.
        curves: training curves by (protocol, run, task id).
        successes: as ``returns``: 1, 0, or -1 where the task defines no success.
    """

    group: TaskGroup
    steps: int
    runs: dict[str, tuple[int, ...]]
    returns: dict[str, Cells]
    curves: dict[tuple[str, int, str], Points] = field(default_factory=dict)
    successes: dict[str, list[list[list[list[int]]]]] = field(default_factory=dict)

    @cached_property
    def means(self) -> dict[str, Means]:
        """Mean raw returns [run][stage][task] by protocol, by ``math.fsum``."""
        return {
            protocol: [[[math.fsum(cell) / len(cell) for cell in row] for row in run] for run in runs]
            for protocol, runs in self.returns.items()
        }

    def success_rates(self, protocol: str) -> tuple[tuple[tuple[float | None, ...], ...], ...]:
        """The share of successful episodes [run][stage][task]; None where undefined, empty if everywhere."""
        rates = tuple(
            tuple(tuple(None if min(cell) < 0 else sum(cell) / len(cell) for cell in row) for row in run)
            for run in self.successes.get(protocol, ())
        )
        is_defined = any(rate is not None for run in rates for row in run for rate in row)
        return rates if is_defined else ()


def group_returns(submitted: SubmittedGroup, budget: str) -> GroupReturns:
    """The returns of a group's checked logs."""
    tasks = len(submitted.group.tasks)

    def cells(column: str) -> dict[str, Any]:
        """A column by protocol, [run][stage][task][episode]."""
        shapes = {name: (-1, len(stages(name, tasks)), tasks, EVALUATION_EPISODES) for name in submitted.logs}
        columns = ((name, log.rows[column].to_numpy()) for name, log in submitted.logs.items())
        return {name: values.reshape(shapes[name]).tolist() for name, values in columns}

    return GroupReturns(
        group=submitted.group,
        steps=BUDGETS[budget].steps_for(submitted.group.name),
        runs={protocol: log.runs for protocol, log in submitted.logs.items()},
        returns=cells("return"),
        curves={
            (protocol, run, curve.task): (curve.steps, curve.returns)
            for protocol, documents in submitted.runs.items()
            for run, document in documents.items()
            for curve in document.curves
        },
        successes=cells("success"),
    )


def normalized_runs(results: GroupReturns, references: References, protocol: str) -> list[NormalizedRun]:
    """One NormalizedRun per training seed of a protocol's log. Every task of the group needs a reference.

    ``single_task``, ``cumulative`` and the areas are filled in where the submission has such runs and curves.
    """
    ids, is_in_order = results.group.task_ids, protocol in IN_ORDER
    T = len(ids)
    first_stage = 0 if is_in_order else T

    def normalized(run: int, episodes: list[list[list[float]]], means: list[list[float]]) -> NormalizedRun:
        """A run from its returns and their means, [stage][task]; the task at position j is at[j]."""
        at = dict(enumerate(task_order(protocol, run, T), 1))
        known = {j: references.tasks[ids[task]] for j, task in at.items()}
        scored = {j: reference for j, reference in known.items() if not reference.open}

        def last_stage(name: str, positions: Iterable[int]) -> dict[int, float]:
            """The scores of the run of this seed in another log, by position."""
            if run not in results.runs.get(name, ()):
                return {}
            (row,) = results.means[name][results.runs[name].index(run)]
            return {j: scored[j].normalize(row[at[j]]) for j in positions}

        def areas(name: str) -> dict[int, float]:
            """The areas under the training curves of the run of this seed, by position."""
            heights = {}
            for j, reference in scored.items():
                steps, values = results.curves.get((name, run, ids[at[j]]), ([], []))
                height = area(steps, [reference.normalize(value) for value in values], results.steps)
                if height is not None:
                    heights[j] = height
            return heights

        return NormalizedRun(
            T=T,
            scored=tuple(scored),
            normalized_returns={
                (s, j): reference.normalize(row[at[j]])
                for s, row in enumerate(means, first_stage)
                for j, reference in scored.items()
            },
            final_episodes={
                j: tuple(map(reference.normalize, episodes[-1][at[j]])) for j, reference in scored.items()
            },
            single_task=last_stage("single", scored),
            cumulative=last_stage("cumulative", [j for j in scored if at[j] == T - 1]),
            auc=areas(protocol) if is_in_order else {},
            single_task_auc=areas("single") if is_in_order else {},
            order=tuple(task + 1 for task in at.values()),
        )

    runs = results.runs[protocol], results.returns[protocol], results.means[protocol]
    return [normalized(*run) for run in zip(*runs, strict=True)]
