"""The rows of a board that follow from the references: the agents of the floor, and each task alone."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

from gym_extensions.catalog.protocol import STANDARD_BUDGET
from gym_extensions.scoring.boards import BoardKey, BoardMetric, ComputedEntry
from gym_extensions.scoring.metrics import BOARD_METRICS, JOINT_GAP, Metric, MetricValue, Run
from gym_extensions.scoring.references import ALONE, RULERS, References, trained_alone
from gym_extensions.scoring.returns import ALL_OPEN, anchor_terms
from gym_extensions.scoring.statistics import Summary, mean_of_groups, summary, with_anchors

FROM_FLOORS = "Computed from the mean returns of the floors, which have no runs and no curves."
FLOORS = {"random": "Random actions", "zero": "Zero actions"}
"""The agents of the floor, by name, with their titles."""
ALONE_TITLE = "Each task alone"
"""The title of the reference agent that was trained on each task alone."""


def floor_values(
    agent: str, task_ids: Sequence[str], references: References, protocol: str
) -> dict[str, MetricValue]:
    """The metrics of an agent of the floor on a group: it ignores observations and never learns.

    Its return on a task is the same after every stage and alone, so that differences of stages are 0. There
    are no runs, so no intervals, and what is computed from episodes or curves has no value.

    Args:
        agent: ``random`` or ``zero``.
        task_ids: the group's tasks.
        references: floors and experts, with the agent's mean return of each task.
        protocol: ``sequential``, ``single``, ``joint`` or ``cumulative``.

    Returns:
        The values by name of the metric; empty where a task has no reference or no such mean.
    """
    known = [references.tasks.get(task) for task in task_ids]
    if any(reference is None or agent not in reference.agents for reference in known):
        return {}
    solved = {j: each for j, each in enumerate(known, 1) if each is not None and not each.open}
    p = {j: reference.normalize(reference.agents[agent]) for j, reference in solved.items()}
    T = len(task_ids)
    stages = {(s, j): value for s in range(T + 1) for j, value in p.items()}
    run = Run(T=T, scored=tuple(solved), normalized_returns=stages, single_task=p)

    def value(metric: Metric) -> float | None:
        if metric is JOINT_GAP:
            return 0.0 if p else None
        try:
            return metric.function(run) if metric.function else None
        except KeyError:
            return None

    return {metric.name: MetricValue(value(metric), why=FROM_FLOORS) for metric in BOARD_METRICS[protocol]}


ALONE_METRICS = ("final_performance", "single_task_performance")
"""The metrics that the reference agent has that was trained on every task alone."""
ONLY_FINAL = "It was trained on every task alone: only its returns at the end are known."


def alone_summaries(task_ids: Sequence[str], references: References) -> dict[str, Summary] | None:
    """The score of the reference agent that was trained on each task alone, by task id, over its runs.

    Returns:
        None where a task has no reference or no such runs; without open tasks otherwise.
    """
    known = trained_alone()
    if any(task not in references.tasks or task not in known for task in task_ids):
        return None
    return {
        task: summary(reference.normalize_all([run.mean for run in known[task].runs]))
        for task in task_ids
        if not (reference := references.tasks[task]).open
    }


def alone_values(
    groups: Sequence[Sequence[str]], references: References, protocol: str
) -> dict[str, MetricValue]:
    """The metrics of the reference agent that was trained on each task of a board alone.

    Its score is the mean over tasks, then over groups. Its standard error is that over the runs of every
    task, which are independent, and of the experts.

    Args:
        groups: the task ids of each group of the board.
        references: floors and experts.
        protocol: ``sequential``, ``single`` or ``joint``.

    Returns:
        The values by name of the metric; empty where a task has no reference or the agent no runs.
    """
    by_group = [alone_summaries(tasks, references) for tasks in groups]
    if any(found is None for found in by_group):
        return {}
    found = [each for each in by_group if each is not None]
    values = {
        metric.name: MetricValue(why=ONLY_FINAL if metric.name not in ALONE_METRICS else ALL_OPEN)
        for metric in BOARD_METRICS[protocol]
    }
    if all(found):
        score = mean_of_groups([mean_of_groups(list(tasks.values())) for tasks in found])
        errors: dict[str, float] = {}
        for tasks in found:
            for task, each in tasks.items():
                share = each.mean / len(tasks) / len(found) * references.tasks[task].relative_error
                errors[task] = errors.get(task, 0.0) + share
        terms = anchor_terms(list(errors.values()), [references.tasks[task] for task in errors])
        for name in ALONE_METRICS:
            if name in values:
                values[name] = MetricValue.of(with_anchors(score, terms))
    return values


def computed_rows(
    key: BoardKey, references: References, tasks: Mapping[str, Sequence[str]], names: Collection[str]
) -> tuple[ComputedEntry, ...]:
    """The reference agent on each task alone, and the agents of the floor, as far as they are known.

    Args:
        key: the board.
        references: floors and experts.
        tasks: the task ids of the groups of the board, by group id.
        names: those of the entries of the board; one that is called ``alone`` takes the place of the row.
    """
    entries = []
    if key.budget == STANDARD_BUDGET and references.version != RULERS[ALONE] and ALONE not in names:
        groups = [tasks[group] for group in key.groups]
        if alone := alone_values(groups, references, key.protocol):
            rows = {
                name: BoardMetric(value.mean, value.low, value.high, value.why)
                for name, value in alone.items()
            }
            entries.append(ComputedEntry(ALONE, ALONE_TITLE, rows))
    for name, title in FLOORS.items():
        values = [floor_values(name, tasks[group], references, key.protocol) for group in key.groups]
        if not all(values):
            continue
        metrics = {}
        for metric in BOARD_METRICS[key.protocol]:
            means = [each[metric.name].mean for each in values]
            present = [mean for mean in means if mean is not None]
            mean = sum(present) / len(present) if len(present) == len(means) else None
            metrics[metric.name] = BoardMetric(mean, None, None, FROM_FLOORS)
        entries.append(ComputedEntry(name, title, metrics))
    return tuple(entries)
