"""The rows of a board that follow from the references: the agents of the floor, and each task alone."""

from collections import defaultdict
from collections.abc import Collection, Mapping, Sequence

from gym_extensions.catalog.protocol import STANDARD_BUDGET
from gym_extensions.metrics import formulas, statistics
from gym_extensions.metrics.values import ALL_OPEN, MetricValue, error_terms
from gym_extensions.references import ALONE, RULERS, References, trained_alone
from gym_extensions.scoring.ranking.boards import BoardKey, BoardMetric, ComputedRow

FROM_FLOORS = "Computed from the mean returns of the floors, which have no runs and no curves."
FLOORS = {"random": "Random actions", "zero": "Zero actions"}
"""The agents of the floor, by name, with their titles."""
ONLY_FINAL = "It was trained on every task alone: only its returns at the end are known."


def computed_rows(
    key: BoardKey, references: References, tasks: Mapping[str, Sequence[str]], names: Collection[str]
) -> tuple[ComputedRow, ...]:
    """The reference agent on each task alone, and the agents of the floor, as far as they are known.

    ``tasks`` are the task ids by group id. A submission called ``alone`` among ``names`` takes the row's
    place.
    """
    groups = [tasks[group] for group in key.groups]
    submissions = []
    has_alone = key.budget == STANDARD_BUDGET and references.version != RULERS[ALONE] and ALONE not in names
    if has_alone and (alone := alone_values(groups, references, key.protocol)):
        rows = {name: BoardMetric.of(value) for name, value in alone.items()}
        submissions.append(ComputedRow(ALONE, "Each task alone", rows))
    for name, title in FLOORS.items():
        values = [floor_values(name, each, references, key.protocol) for each in groups]
        if not all(values):
            continue
        metrics = {}
        for metric in formulas.BOARD_METRICS[key.protocol]:
            means = [mean for each in values if (mean := each[metric.name]) is not None]
            mean = sum(means) / len(means) if len(means) == len(values) else None
            metrics[metric.name] = BoardMetric(mean, None, None, FROM_FLOORS)
        submissions.append(ComputedRow(name, title, metrics))
    return tuple(submissions)


def floor_values(
    agent: str, task_ids: Sequence[str], references: References, protocol: str
) -> dict[str, float | None]:
    """The metrics of an agent of the floor on a group, by name: it ignores observations and never learns.

    Its return on a task is the same after every stage and alone, so that differences of stages are 0. There
    are no runs: what is computed from episodes or curves is None. Empty where a task has no reference or no
    mean return of that agent.
    """
    known = [references.tasks.get(task) for task in task_ids]
    if any(reference is None or agent not in reference.floor.agents for reference in known):
        return {}
    scored = {j: each for j, each in enumerate(known, 1) if each and not each.open}
    p = {j: each.normalize(each.floor.agents[agent].mean) for j, each in scored.items()}
    T = len(task_ids)
    stages = {(s, j): value for s in range(T + 1) for j, value in p.items()}
    run = formulas.NormalizedRun(T=T, scored=tuple(p), normalized_returns=stages, single_task=p)
    values: dict[str, float | None] = {}
    for metric in formulas.BOARD_METRICS[protocol]:
        try:
            values[metric.name] = metric.of_run(run)
        except KeyError:
            values[metric.name] = None
    if formulas.JOINT_GAP.name in values and p:
        values[formulas.JOINT_GAP.name] = 0.0
    return values


def alone_values(
    groups: Sequence[Sequence[str]], references: References, protocol: str
) -> dict[str, MetricValue]:
    """The metrics of the reference agent that was trained on each task of a board alone, by name.

    Its score is the mean over tasks, then over groups. Its standard error is that over the runs of every
    task, which are independent, and of the experts. Empty where a task has no reference or the agent no runs.
    """
    known = trained_alone()
    if any(task not in references.tasks or task not in known for tasks in groups for task in tasks):
        return {}
    scores: list[dict[str, statistics.Summary]] = []
    for tasks in groups:
        scored = {task: references.tasks[task] for task in tasks if not references.tasks[task].open}
        runs = {task: [each.normalize(run.mean) for run in known[task].runs] for task, each in scored.items()}
        scores.append({task: statistics.summary(means) for task, means in runs.items()})
    has_value = {metric.name: "alone" in metric.shown for metric in formulas.BOARD_METRICS[protocol]}
    values = {name: MetricValue(why=ALL_OPEN if has else ONLY_FINAL) for name, has in has_value.items()}
    if all(scores):
        score = statistics.mean_of_groups([statistics.mean_of_groups(list(part.values())) for part in scores])
        errors: dict[str, float] = defaultdict(float)
        for part in scores:
            for task, each in part.items():
                errors[task] += each.mean / len(part) / len(scores) * references.tasks[task].expert_error[0]
        terms = error_terms(errors.values(), [references.tasks[task].expert_error for task in errors])
        value = MetricValue.of(statistics.to_interval(score, terms))
        values |= {name: value for name, has in has_value.items() if has}
    return values
