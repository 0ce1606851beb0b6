"""The content of a references file: measures every task that the file does not have yet."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from gym_extensions.baselines.execution.failures import Failure, jobs_failed
from gym_extensions.baselines.execution.workers import Workers
from gym_extensions.baselines.references.existing import FORMAT, existing_rows, is_provisional
from gym_extensions.baselines.references.logs import write_ceiling_log, write_floor_log
from gym_extensions.baselines.references.measure import ORACLE, Measurement, PendingMeasurement
from gym_extensions.baselines.references.rows import floor_row, task_row
from gym_extensions.baselines.reporting.display import Screen
from gym_extensions.baselines.training.events import JobFailed, JobPlan, StagePlan, TrainingStarted
from gym_extensions.catalog.protocol import FIRST_REFERENCE_RUN
from gym_extensions.catalog.task import Task
from gym_extensions.envs.fingerprint import fingerprint_of
from gym_extensions.rollouts.episodes import Episode
from gym_extensions.rollouts.layout import PROGRESS

FLOOR_AGENTS = ("random", "zero")
CEILING_AGENT = "trpo"
"""The ceilings of the references ``provisional`` were measured with ``trpo-2017``."""
FLOOR_EPISODES, CEILING_EPISODES = 1000, 100

Results = Mapping[Measurement, list[Episode]]


def floor_measurements(task: Task) -> dict[str, Measurement]:
    """The measurements of a task's floor, by agent."""
    return {agent: Measurement(task, agent, FIRST_REFERENCE_RUN, FLOOR_EPISODES) for agent in FLOOR_AGENTS}


def ceiling_measurements(
    task: Task, budget: str, runs: Sequence[int], agent: str = CEILING_AGENT
) -> list[Measurement]:
    """The measurements of a task's ceiling: the reference runs, or the oracle in navigation."""
    if task.base == "Navigation":
        return [Measurement(task, ORACLE, FIRST_REFERENCE_RUN, FLOOR_EPISODES)]
    return [Measurement(task, agent, run, CEILING_EPISODES, budget) for run in runs]


def measure_all(
    budgets: Mapping[Task, str],
    *,
    agent: str,
    runs: Sequence[int],
    out: Path,
    jobs: int,
    screen: Screen,
    floors_only: bool = False,
) -> dict[str, Any]:
    """Measures every task. Episodes are logged beside ``out``, and finished measurements are stored.

    If ``out`` exists, its rows stay as they are: a floor or ceiling in it is not measured again.

    Args:
        budgets: the training budget of the reference runs, by task.
        agent: the reference agent whose mean return is the ceiling.
        runs: the training seeds of the reference runs.
        out: the path of the references file; its stem is the version.
        jobs: number of worker processes.
        screen: shows the progress.
        floors_only: leaves the ceilings out.

    Returns:
        The references file's content.

    Raises:
        BenchError: ``out`` is not a references file or has another definition of a task, or a measurement
            failed.
    """
    rows = existing_rows(out, budgets)
    ceilings = {
        task: ceiling_measurements(task, budget, runs, agent)
        for task, budget in budgets.items()
        if not floors_only and "ceiling" not in rows.get(task.id, {})
    }
    floors = {task: floor_measurements(task) for task in budgets if task.id not in rows}
    measurements = [each for row in ceilings.values() for each in row]
    measurements += [each for row in floors.values() for each in row.values()]
    plans = (JobPlan(each.title, (StagePlan(1, each.steps, each.episodes),)) for each in measurements)
    screen.show(TrainingStarted(tuple(plans), jobs))
    folder = out.parent / PROGRESS / out.stem
    pending = [PendingMeasurement(each, folder) for each in measurements]
    results: dict[Measurement, list[Episode]] = {}
    failures: dict[str, Failure] = {}
    for index, outcome in Workers(jobs).run(pending, screen.show):
        each = measurements[index]
        if isinstance(outcome, Failure):
            failures[each.title] = outcome
            screen.show(JobFailed(each.title, outcome.cause))
        else:
            results[each] = outcome
    if failures:
        raise jobs_failed(
            failures, len(measurements), "Finished measurements are stored; repeat the command."
        )
    logs = out.parent / f"{out.stem}-logs"
    rows = existing_rows(out, budgets)  # another process may have added rows since
    for task, agents in floors.items():
        rows[task.id] = {"floor": _floor(task, agents, results, logs)}
    for task, reference_runs in ceilings.items():
        rows[task.id] = _with_ceiling(task, rows[task.id]["floor"], reference_runs, results, logs)
    provisional = is_provisional(rows.values())
    return {"format": FORMAT, "version": out.stem, "provisional": provisional, "tasks": rows}


def _floor(
    task: Task, measurements: Mapping[str, Measurement], results: Results, logs: Path
) -> dict[str, Any]:
    """The floor of one task; writes its log."""
    episodes = {agent: results[each] for agent, each in measurements.items()}
    return floor_row(
        {agent: _returns(rows) for agent, rows in episodes.items()},
        {agent: each.agent_seed for agent, each in measurements.items()},
        fingerprint=fingerprint_of(task),
        log_sha256=write_floor_log(logs, task.id, episodes),
    )


def _with_ceiling(
    task: Task, floor: Mapping[str, Any], measurements: Sequence[Measurement], results: Results, logs: Path
) -> dict[str, Any]:
    """The row of one task; writes the log of its reference runs."""
    return task_row(
        floor,
        {each.run: _returns(results[each]) for each in measurements},
        agent=measurements[0].agent,
        budget=measurements[0].budget,
        log_sha256=write_ceiling_log(logs, task.id, [row for each in measurements for row in results[each]]),
    )


def _returns(episodes: Sequence[Episode]) -> list[float]:
    return [row.return_ for row in episodes]
