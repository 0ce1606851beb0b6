"""Rules about evaluations.csv, the evaluations during training."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from gym_extensions.catalog.protocol import EVALUATION_EPISODES, PROTOCOLS, stages
from gym_extensions.rollouts.problem import Finding, quote, row_findings
from gym_extensions.rollouts.reading.interim_evaluations import Evaluations
from gym_extensions.rollouts.rules.rule import rule


def _findings(
    evaluations: Evaluations, is_wrong: Callable[[int], bool], message: Callable[[int], str], hint: str
) -> Iterator[Finding]:
    rows = [row for row in range(evaluations.step.size) if is_wrong(row)]
    yield from row_findings(evaluations.path, rows, message, hint, evaluations.numbers)


@rule("evaluations")
def foreign_evaluation(evaluations: Evaluations) -> Iterator[Finding]:
    """Every row of evaluations.csv belongs to a task of the group, and to a run and a stage with training of
    one of its logs."""
    group, members = evaluations.group, set(evaluations.group.task_ids)

    def message(row: int) -> str:
        protocol, run, stage = evaluations.protocol[row], evaluations.run[row], evaluations.stage[row]
        if protocol not in PROTOCOLS:
            return f"Unknown protocol {quote(protocol)}."
        if evaluations.task[row] not in members:
            return f"{quote(evaluations.task[row])} is not a task of {group.id}."
        if stage < 1 or stage not in stages(protocol, len(group.tasks)):
            return f"Stage {stage} of {protocol}.csv has no training."
        runs = evaluations.runs.get(protocol, ())
        return "" if runs is None or run in runs else f"{protocol}.csv has no run {run}."

    hint = "Include only evaluations during the training of logged runs."
    yield from _findings(evaluations, lambda row: bool(message(row)), message, hint)


@rule("evaluations")
def evaluation_order(evaluations: Evaluations) -> Iterator[Finding]:
    """The rows of evaluations.csv are sorted by protocol, run, stage, step and task in training order, and
    none is repeated."""
    positions = {task: position for position, task in enumerate(evaluations.group.task_ids)}
    keys = [
        (protocol, run, stage, step, positions.get(task, -1))
        for protocol, run, stage, step, task in zip(
            evaluations.protocol,
            evaluations.run.tolist(),
            evaluations.stage.tolist(),
            evaluations.step.tolist(),
            evaluations.task,
            strict=True,
        )
    ]
    hint = "Sort by protocol, run, stage, step and task in training order; write each evaluation once."
    yield from _findings(
        evaluations,
        lambda row: row > 0 and keys[row] <= keys[row - 1],
        lambda row: f"Step {evaluations.step[row]} of {quote(evaluations.task[row])} is not in order.",
        hint,
    )


@rule("evaluations")
def evaluation_episodes(evaluations: Evaluations) -> Iterator[Finding]:
    """An evaluation during training has 1 to 20 episodes, those with a prescribed seed."""
    yield from _findings(
        evaluations,
        lambda row: not 1 <= evaluations.episodes[row] <= EVALUATION_EPISODES,
        lambda row: f"Column `episodes` is {evaluations.episodes[row]}.",
        f"Write the number of episodes, 1 to {EVALUATION_EPISODES}.",
    )


@rule("evaluations")
def evaluation_step(evaluations: Evaluations) -> Iterator[Finding]:
    """The step of an evaluation during training is at least 1 and less than the steps of its stage."""
    budget, group = evaluations.budget, evaluations.group
    steps = budget.steps_for(group.name) if budget else np.inf

    def limit(row: int) -> float:
        return steps * (len(group.tasks) if evaluations.protocol[row] == "joint" else 1)

    yield from _findings(
        evaluations,
        lambda row: not 1 <= evaluations.step[row] < limit(row),
        lambda row: f"Step {evaluations.step[row]} is not between 1 and the end of the stage.",
        "Count steps from the beginning of the stage; the log has the evaluation at its end.",
    )


@rule("evaluations")
def impossible_evaluation_return(evaluations: Evaluations) -> Iterator[Finding]:
    """A return of evaluations.csv is a finite number within the bounds of the task's episode return
    (catalog/bodies)."""
    bounds = {task.id: task.return_bounds for task in evaluations.group.tasks}

    def is_wrong(row: int) -> bool:
        low, high = bounds.get(evaluations.task[row], (-np.inf, np.inf))
        value = evaluations.return_[row]
        return not (np.isfinite(value) and low <= value <= high)

    yield from _findings(
        evaluations,
        is_wrong,
        lambda row: f"Column `return` is {float(evaluations.return_[row])!r}; no episodes have this mean.",
        "Write the mean of the undiscounted, unscaled returns of the episodes.",
    )
