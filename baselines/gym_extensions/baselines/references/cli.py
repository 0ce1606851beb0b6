"""gym-extensions reference: measures floors and ceilings and writes the file that normalizes scores."""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from gym_extensions.atomic import write_text
from gym_extensions.baselines import algorithms
from gym_extensions.baselines.execution.failures import Failure, jobs_failed
from gym_extensions.baselines.execution.workers import Workers
from gym_extensions.baselines.references.logs import write_ceiling_log, write_floor_log
from gym_extensions.baselines.references.measure import ORACLE, Measurement, PendingMeasurement
from gym_extensions.baselines.references.rows import floor_row, task_row
from gym_extensions.baselines.reporting.display import Screen, open_screen
from gym_extensions.baselines.training.events import JobFailed, JobPlan, StagePlan, TrainingStarted
from gym_extensions.baselines.training.request import parse_groups, parse_names, parse_runs, require_positive
from gym_extensions.catalog.budgets import BUDGETS
from gym_extensions.catalog.budgets import budget as budget_named
from gym_extensions.catalog.protocol import FIRST_REFERENCE_RUN, FULL_ENTRY_RUNS
from gym_extensions.catalog.task import Task
from gym_extensions.envs.fingerprint import fingerprint_of, require_published_engine
from gym_extensions.errors import BenchError, reports_mistakes
from gym_extensions.rollouts.episodes import Episode
from gym_extensions.rollouts.layout import PROGRESS

FLOOR_AGENTS = ("random", "zero")
CEILING_AGENT = "trpo"
"""The ceilings of the references ``provisional`` were measured with ``trpo-2017``."""
FLOOR_EPISODES, CEILING_EPISODES = 1000, 100
REFERENCE_BUDGET = "1M"

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
    budgets: Mapping[Task, str], *, agent: str, runs: Sequence[int], out: Path, jobs: int, screen: Screen
) -> dict[str, Any]:
    """Measures every task. Episodes are logged beside ``out``, and finished measurements are stored.

    Args:
        budgets: the training budget of the reference runs, by task.
        agent: the reference agent whose mean return is the ceiling.
        runs: the training seeds of the reference runs.
        out: the path of the references file; its stem is the version.
        jobs: number of worker processes.
        screen: shows the progress.

    Returns:
        The references file's content.
    """
    ceilings = {task: ceiling_measurements(task, budget, runs, agent) for task, budget in budgets.items()}
    floors = {task: floor_measurements(task) for task in budgets}
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
    tasks = {task.id: _task(task, floors[task], ceilings[task], results, logs) for task in budgets}
    final = set(budgets.values()) == {REFERENCE_BUDGET} and len(runs) >= FULL_ENTRY_RUNS
    return {"format": 1, "version": out.stem, "provisional": not final, "tasks": tasks}


def _task(
    task: Task,
    floors: Mapping[str, Measurement],
    ceilings: Sequence[Measurement],
    results: Results,
    logs: Path,
) -> dict[str, Any]:
    """The row of one task; writes its two logs."""
    floor_episodes = {agent: results[each] for agent, each in floors.items()}
    floor = floor_row(
        {agent: _returns(episodes) for agent, episodes in floor_episodes.items()},
        {agent: each.agent_seed for agent, each in floors.items()},
        fingerprint=fingerprint_of(task),
        log_sha256=write_floor_log(logs, task.id, floor_episodes),
    )
    return task_row(
        floor,
        {each.run: _returns(results[each]) for each in ceilings},
        agent=ceilings[0].agent,
        budget=ceilings[0].budget,
        log_sha256=write_ceiling_log(logs, task.id, [row for each in ceilings for row in results[each]]),
    )


def _returns(episodes: Sequence[Episode]) -> list[float]:
    return [row.return_ for row in episodes]


def task_budgets(groups: str, budgets: str) -> dict[Task, str]:
    """The budget of each task, from comma-separated groups and one budget for all or one per group.

    Raises:
        BenchError: an unknown name, another number of budgets, or two budgets for one task.
    """
    chosen_groups, budget_names = parse_groups(parse_names(groups)), parse_names(budgets)
    if len(budget_names) not in (1, len(chosen_groups)):
        message = f"There are {len(chosen_groups)} groups and {len(budget_names)} budgets."
        raise BenchError("bad-budget", message, "--budget", "Use one budget, or one per group.")
    if len(budget_names) == 1:
        budget_names *= len(chosen_groups)
    chosen: dict[Task, str] = {}
    for group, budget_name in zip(chosen_groups, budget_names, strict=True):
        for task in group.tasks:
            if chosen.setdefault(task, budget_named(budget_name).name) != budget_name:
                message = f"{task.id} is in two groups with the budgets {chosen[task]} and {budget_name}."
                raise BenchError("bad-budget", message, "--budget", "Use the same budget for these groups.")
    return chosen


def parser() -> argparse.ArgumentParser:
    """The command's options."""
    command = argparse.ArgumentParser(
        prog="gym-extensions reference",
        description="Measure floors (random and zero actions) and ceilings (an agent or the oracle).",
    )
    command.add_argument(
        "--groups", required=True, help="comma-separated: names of groups, or TOML files of custom groups"
    )
    command.add_argument(
        "--budget",
        default=REFERENCE_BUDGET,
        help=f"one for all groups, or comma-separated, one per group: {', '.join(BUDGETS)} (default: 1M)",
    )
    command.add_argument(
        "--runs", default="1000-1004", help="training seeds, at least 1000 (default: 1000-1004)"
    )
    command.add_argument(
        "--agent",
        default=CEILING_AGENT,
        choices=algorithms.names(),
        help=f"the agent that measures the ceilings (default: {CEILING_AGENT})",
    )
    command.add_argument("--out", required=True, type=Path, help="the file; its stem is the version's name")
    command.add_argument("--jobs", type=int, default=1, help="worker processes (default: 1)")
    return command


@reports_mistakes
def main(argv: list[str] | None = None) -> int:
    """Measures and writes the references file."""
    options = parser().parse_args(argv)
    runs, budgets = parse_runs(options.runs), task_budgets(options.groups, options.budget)
    for run in runs:
        if run < FIRST_REFERENCE_RUN:
            hint = f"Use numbers from {FIRST_REFERENCE_RUN}; smaller ones are reserved for submissions."
            raise BenchError("bad-run", f"Run {run} is out of range.", "--runs", hint)
    require_positive(options.jobs, "--jobs")
    require_published_engine()
    with open_screen() as screen:
        content = measure_all(
            budgets, agent=options.agent, runs=runs, out=options.out, jobs=options.jobs, screen=screen
        )
    write_text(options.out, json.dumps(content, indent=1, ensure_ascii=False) + "\n")
    print(f"The references are in {options.out}.")
    return 0
