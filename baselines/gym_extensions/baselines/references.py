"""gym-extensions reference: floors and ceilings, measured; the file that normalises every score."""

from __future__ import annotations

import argparse
import hashlib
import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from gym_extensions.baselines.cli import numbers
from gym_extensions.baselines.jobs import run_all
from gym_extensions.baselines.measuring import ORACLE, Measurement, MeasurementWork
from gym_extensions.baselines.progress import FOLDER
from gym_extensions.baselines.show import Screen, shown
from gym_extensions.catalog.errors import BenchError, reports_mistakes
from gym_extensions.catalog.groups import group
from gym_extensions.catalog.protocol import BUDGETS, FIRST_REFERENCE_RUN, FULL_ENTRY_RUNS
from gym_extensions.catalog.protocol import budget as budget_named
from gym_extensions.catalog.tasks import task as task_named
from gym_extensions.scoring.log import Episode, write_episodes, write_text

FLOOR_AGENTS = ("random", "still")
CEILING_AGENT = "trpo"
FLOOR_EPISODES, CEILING_EPISODES = 1000, 100
REFERENCE_BUDGET = "1M"
CLEAR_ERRORS, CLEAR_DEVIATIONS, CLEAR_RUNS = 5.0, 1.0, 3
"""A run beats the floor by so many standard errors and deviations; so many runs of five or more must."""


def summary(returns: Sequence[float]) -> dict[str, float]:
    """Mean, population standard deviation and standard error of the mean of episode returns."""
    mean = math.fsum(returns) / len(returns)
    std = math.sqrt(math.fsum((value - mean) ** 2 for value in returns) / len(returns))
    return {"mean": mean, "std": std, "standard_error": std / math.sqrt(len(returns))}


def beats_floor(run: dict[str, float], floor: dict[str, float]) -> bool:
    """Whether a run is above the floor by five standard errors and by one deviation of its own episodes."""
    above = run["mean"] - floor["mean"]
    error = math.hypot(run["standard_error"], floor["standard_error"])
    return above >= CLEAR_ERRORS * error and above >= CLEAR_DEVIATIONS * run["std"] and above > 0


def is_open(beaten: Sequence[bool]) -> bool:
    """Whether nobody has learned the task: fewer than three runs did, or, of under five, not all."""
    if len(beaten) < FULL_ENTRY_RUNS:
        return not all(beaten)
    return sum(beaten) < CLEAR_RUNS


def task_row(
    floors: Mapping[str, Sequence[float]],
    runs: Mapping[int, Sequence[float]],
    *,
    agent: str = CEILING_AGENT,
    budget: str,
    log_sha256: str,
) -> dict[str, Any]:
    """The references of one task, from the returns of the floor's agents and of the reference runs."""
    agents = {name: summary(returns) for name, returns in floors.items()}
    better = max(agents, key=lambda name: agents[name]["mean"])
    floor = agents[better]
    rows, passes = [], []
    for run, returns in sorted(runs.items()):
        found = summary(returns)
        passed = beats_floor(found, floor)
        passes.append(passed)
        rows.append({"run": run, "mean": found["mean"], "std": found["std"], "beats_floor": passed})
    means = [summary(returns)["mean"] for _, returns in sorted(runs.items())]
    mean = math.fsum(means) / len(means)
    spread = math.sqrt(math.fsum((value - mean) ** 2 for value in means) / max(1, len(means) - 1))
    ceiling = {
        "mean": mean,
        "agent": agent,
        "budget": budget,
        "episodes": len(next(iter(runs.values()))),
        "standard_error": spread / math.sqrt(len(means)),
        "runs": rows,
        "log_sha256": log_sha256,
    }
    open_ = is_open(passes)
    row = {
        "floor": {
            "mean": floor["mean"],
            "agent": better,
            "episodes": len(floors[better]),
            "agents": agents,
        },
        "ceiling": None if open_ else ceiling,
        "open": open_,
    }
    return row | ({"attempts": ceiling} if open_ else {})


def returns(episodes: Sequence[Episode]) -> list[float]:
    """The returns of the episodes."""
    return [row.return_ for row in episodes]


def ceiling_measurements(task_id: str, budget: str, runs: Sequence[int]) -> list[Measurement]:
    """What measures a task's ceiling: the reference runs, or the oracle where the task is navigation."""
    if task_named(task_id).base == "Navigation":
        return [Measurement(task_id, ORACLE, FIRST_REFERENCE_RUN, FLOOR_EPISODES)]
    return [Measurement(task_id, CEILING_AGENT, run, CEILING_EPISODES, budget) for run in runs]


def measured(
    task_ids: Sequence[str], *, budget: str, runs: Sequence[int], out: Path, jobs: int, screen: Screen
) -> dict[str, Any]:
    """The whole document; logs of its episodes are written beside ``out``, parts of unfinished work kept."""
    ceilings = [each for task in task_ids for each in ceiling_measurements(task, budget, runs)]
    floors_of = [
        Measurement(task, agent, FIRST_REFERENCE_RUN, FLOOR_EPISODES)
        for task in task_ids
        for agent in FLOOR_AGENTS
    ]
    wanted = [*ceilings, *floors_of]
    screen.plan({each.title: 1 for each in wanted})
    parts = out.parent / FOLDER / out.stem
    found: dict[Measurement, list[Episode]] = {}
    for index, episodes in run_all([MeasurementWork(each, parts) for each in wanted], jobs, screen.hear):
        found[wanted[index]] = episodes
    tasks = {}
    for task in task_ids:
        own = {each: episodes for each, episodes in found.items() if each.task == task}
        top = [each for each in own if each.agent not in FLOOR_AGENTS]
        path = out.parent / f"{out.stem}-logs" / f"{task.rpartition('/')[2]}.csv"
        write_episodes(path, [row for each in top for row in own[each]], (task,))
        tasks[task] = task_row(
            {each.agent: returns(own[each]) for each in own if each.agent in FLOOR_AGENTS},
            {each.run: returns(own[each]) for each in top},
            agent=top[0].agent,
            budget=top[0].budget,
            log_sha256=hashlib.sha256(path.read_bytes()).hexdigest(),
        )
    final = budget == REFERENCE_BUDGET and len(runs) >= FULL_ENTRY_RUNS
    return {"format": 1, "version": out.stem, "provisional": not final, "tasks": tasks}


@reports_mistakes
def main(argv: list[str] | None = None) -> int:
    """Measures, and writes the file."""
    command = argparse.ArgumentParser(
        prog="gym-extensions reference",
        description="Measure floors (random and zero actions) and ceilings (trpo alone, or the oracle).",
    )
    command.add_argument("--groups", required=True, help="names by commas")
    command.add_argument("--budget", default=REFERENCE_BUDGET, help=f"of {', '.join(BUDGETS)}")
    command.add_argument("--runs", default="1000-1004", help="training seeds from 1000 on")
    command.add_argument("--out", required=True, type=Path, help="the file; its stem is the version's name")
    command.add_argument("--jobs", type=int, default=1, help="processes side by side")
    asked = command.parse_args(argv)
    runs, budget = numbers(asked.runs), budget_named(asked.budget).name
    for run in runs:
        if run < FIRST_REFERENCE_RUN:
            hint = f"Give numbers from {FIRST_REFERENCE_RUN} on; those below are for submissions."
            raise BenchError("bad-run", f"{run} is no reference run.", "--runs", hint)
    if asked.jobs < 1:
        raise BenchError("bad-jobs", f"{asked.jobs} processes are too few.", "--jobs", "Give at least 1.")
    ids = dict.fromkeys(task for name in asked.groups.split(",") for task in group(name.strip()).task_ids)
    with shown() as screen:
        document = measured(
            list(ids), budget=budget, runs=runs, out=asked.out, jobs=asked.jobs, screen=screen
        )
    write_text(asked.out, json.dumps(document, indent=1, ensure_ascii=False) + "\n")
    print(f"The references are in {asked.out}.")  # noqa: T201
    return 0
