"""gym-extensions reference: floors and ceilings, measured; the file that normalizes every score."""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from gym_extensions.atomic import write_text
from gym_extensions.baselines.cli import numbers
from gym_extensions.baselines.references.logs import ceiling_log, floor_log
from gym_extensions.baselines.references.measure import ORACLE, Measurement, MeasurementWork, agent_seed
from gym_extensions.baselines.references.rows import floor_row, task_row
from gym_extensions.baselines.training.display import Screen, shown
from gym_extensions.baselines.training.progress import FOLDER
from gym_extensions.baselines.training.workers import run_all
from gym_extensions.catalog.budgets import BUDGETS
from gym_extensions.catalog.budgets import budget as budget_named
from gym_extensions.catalog.fingerprints import published
from gym_extensions.catalog.groups import group
from gym_extensions.catalog.protocol import FIRST_REFERENCE_RUN, FULL_ENTRY_RUNS
from gym_extensions.catalog.registry import task as task_named
from gym_extensions.errors import BenchError, reports_mistakes
from gym_extensions.rollouts.episodes import Episode

FLOOR_AGENTS = ("random", "still")
CEILING_AGENT = "trpo"
FLOOR_EPISODES, CEILING_EPISODES = 1000, 100
REFERENCE_BUDGET = "1M"


def returns(episodes: Sequence[Episode]) -> list[float]:
    """The returns of the episodes."""
    return [row.return_ for row in episodes]


def floor_measurements(task_id: str) -> dict[str, Measurement]:
    """What measures a task's floor, by the blind agent."""
    return {agent: Measurement(task_id, agent, FIRST_REFERENCE_RUN, FLOOR_EPISODES) for agent in FLOOR_AGENTS}


def ceiling_measurements(task_id: str, budget: str, runs: Sequence[int]) -> list[Measurement]:
    """What measures a task's ceiling: the reference runs, or the oracle where the task is navigation."""
    if task_named(task_id).base == "Navigation":
        return [Measurement(task_id, ORACLE, FIRST_REFERENCE_RUN, FLOOR_EPISODES)]
    return [Measurement(task_id, CEILING_AGENT, run, CEILING_EPISODES, budget) for run in runs]


def measured(
    budgets: Mapping[str, str], *, runs: Sequence[int], out: Path, jobs: int, screen: Screen
) -> dict[str, Any]:
    """The whole document; its episodes are logged beside ``out``, parts of unfinished work are kept.

    Args:
        budgets: for each task id, what its reference runs are trained for.
        runs: the reference runs' training seeds.
        out: the file that the document is for; its stem is the version.
        jobs: processes side by side.
        screen: shown what happens.
    """
    ceilings = [each for task, own in budgets.items() for each in ceiling_measurements(task, own, runs)]
    wanted = [*ceilings, *(each for task in budgets for each in floor_measurements(task).values())]
    screen.plan({each.title: 1 for each in wanted})
    parts = out.parent / FOLDER / out.stem
    found: dict[Measurement, list[Episode]] = {}
    for index, episodes in run_all([MeasurementWork(each, parts) for each in wanted], jobs, screen.hear):
        found[wanted[index]] = episodes
    logs = out.parent / f"{out.stem}-logs"
    tasks = {task: _task(task, found, logs) for task in budgets}
    final = set(budgets.values()) == {REFERENCE_BUDGET} and len(runs) >= FULL_ENTRY_RUNS
    return {"format": 1, "version": out.stem, "provisional": not final, "tasks": tasks}


def _task(task: str, found: Mapping[Measurement, list[Episode]], logs: Path) -> dict[str, Any]:
    """The row of one task out of all measurements; writes its two logs."""
    blind = floor_measurements(task)
    top = [each for each in found if each.task == task and each not in blind.values()]
    floor = floor_row(
        {agent: returns(found[each]) for agent, each in blind.items()},
        {agent: agent_seed(each) for agent, each in blind.items()},
        fingerprint=published(task),
        log_sha256=floor_log(logs, task, {agent: found[each] for agent, each in blind.items()}),
    )
    return task_row(
        floor,
        {each.run: returns(found[each]) for each in top},
        agent=top[0].agent,
        budget=top[0].budget,
        log_sha256=ceiling_log(logs, task, [row for each in top for row in found[each]]),
    )


def budgets_of(groups: str, budgets: str) -> dict[str, str]:
    """Each task's budget, of groups named by commas: one budget for all, or one a group.

    Raises BenchError for a name that is not known, another number of budgets, and a task that would have two.
    """
    names, given = ([name.strip() for name in listed.split(",")] for listed in (groups, budgets))
    if len(given) not in (1, len(names)):
        found = f"{len(names)} groups have {len(given)} budgets."
        raise BenchError("bad-budget", found, "--budget", "Give one for all groups, or one a group.")
    chosen: dict[str, str] = {}
    for name, own in zip(names, given * (len(names) // len(given)), strict=True):
        for task in group(name).task_ids:
            if chosen.setdefault(task, budget_named(own).name) != own:
                found = f"{task} is in two of the groups, with the budgets {chosen[task]} and {own}."
                raise BenchError("bad-budget", found, "--budget", "Give these groups the same budget.")
    return chosen


@reports_mistakes
def main(argv: list[str] | None = None) -> int:
    """Measures, and writes the file."""
    command = argparse.ArgumentParser(
        prog="gym-extensions reference",
        description="Measure floors (random and zero actions) and ceilings (trpo alone, or the oracle).",
    )
    command.add_argument("--groups", required=True, help="names by commas")
    command.add_argument(
        "--budget", default=REFERENCE_BUDGET, help=f"one for all groups, or one a group: {', '.join(BUDGETS)}"
    )
    command.add_argument("--runs", default="1000-1004", help="training seeds from 1000 on")
    command.add_argument("--out", required=True, type=Path, help="the file; its stem is the version's name")
    command.add_argument("--jobs", type=int, default=1, help="processes side by side")
    asked = command.parse_args(argv)
    runs, budgets = numbers(asked.runs), budgets_of(asked.groups, asked.budget)
    for run in runs:
        if run < FIRST_REFERENCE_RUN:
            hint = f"Give numbers from {FIRST_REFERENCE_RUN} on; those below are for submissions."
            raise BenchError("bad-run", f"{run} is no reference run.", "--runs", hint)
    if asked.jobs < 1:
        raise BenchError("bad-jobs", f"{asked.jobs} processes are too few.", "--jobs", "Give at least 1.")
    with shown() as screen:
        document = measured(budgets, runs=runs, out=asked.out, jobs=asked.jobs, screen=screen)
    write_text(asked.out, json.dumps(document, indent=1, ensure_ascii=False) + "\n")
    print(f"The references are in {asked.out}.")
    return 0
