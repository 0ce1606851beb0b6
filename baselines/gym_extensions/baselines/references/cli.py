"""gym-extensions reference: measures floors and ceilings and writes the file that normalizes scores."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from gym_extensions.atomic import write_text
from gym_extensions.baselines import algorithms
from gym_extensions.baselines.references.content import CEILING_AGENT, measure_all
from gym_extensions.baselines.reporting.display import open_screen
from gym_extensions.baselines.submission.folder import prepare
from gym_extensions.baselines.training.request import parse_groups, parse_names, parse_runs, require_positive
from gym_extensions.catalog.budgets import BUDGETS, STANDARD_BUDGET
from gym_extensions.catalog.budgets import budget as budget_named
from gym_extensions.catalog.protocol import FIRST_REFERENCE_RUN
from gym_extensions.catalog.task import Task
from gym_extensions.envs.fingerprint import require_published_engine
from gym_extensions.errors import BenchError, reports_mistakes


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
        default=STANDARD_BUDGET,
        help="one for all groups, or comma-separated, one per group: "
        f"{', '.join(BUDGETS)} (default: {STANDARD_BUDGET})",
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
    command.add_argument(
        "--out",
        required=True,
        type=Path,
        help="the file; its stem is the version's name; rows of an existing file stay as they are",
    )
    command.add_argument("--floors-only", action="store_true", help="measure floors and leave ceilings out")
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
    if options.out.is_dir():
        raise BenchError(
            "bad-out", "It is a folder.", str(options.out), "Name a file, such as references.json."
        )
    prepare(options.out.parent)
    with open_screen() as screen:
        content = measure_all(
            budgets,
            agent=options.agent,
            runs=runs,
            out=options.out,
            jobs=options.jobs,
            screen=screen,
            floors_only=options.floors_only,
        )
    write_text(options.out, json.dumps(content, indent=1, ensure_ascii=False) + "\n")
    print(f"The references are in {options.out}.")
    return 0
