"""Writes and checks the references that normalize scores.

The published file has a floor of every task, the better one of random and zero actions, and its expert: a
policy of :mod:`gym_extensions.experts`, or the planner in navigation. In a file of custom groups the expert
is an agent that is trained on the task alone. Every episode follows from its seed, so that anybody can
measure them again.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterable, Sequence
from pathlib import Path

import msgspec

from gym_extensions import experts
from gym_extensions.baselines import algorithms
from gym_extensions.baselines.entry import prepare
from gym_extensions.baselines.experts.checking import measured_again, shape_problem
from gym_extensions.baselines.experts.measuring import QUICK
from gym_extensions.baselines.measurement import (
    FLOOR_AGENTS,
    PLANNER,
    Measurement,
    Results,
    floor_measurements,
    measure,
    planner_measurement,
    returns_of,
    summary,
    trained_measurements,
)
from gym_extensions.baselines.training.request import parse_groups, parse_names, parse_runs, require_positive
from gym_extensions.catalog.protocol import (
    BUDGETS,
    FIRST_REFERENCE_RUN,
    FULL_ENTRY_RUNS,
    STANDARD_BUDGET,
)
from gym_extensions.catalog.tasks import TASKS, Task
from gym_extensions.envs.fingerprint import fingerprint_of, require_published_engine
from gym_extensions.errors import BenchError, reports_mistakes
from gym_extensions.experts import EPISODES, beats_floor
from gym_extensions.experts import references as model
from gym_extensions.experts.references import (
    CURRENT,
    REFERENCES,
    Expert,
    File,
    Floor,
    FloorAgent,
    Run,
    parse_file,
)
from gym_extensions.files import write_bytes
from gym_extensions.rollouts.layout import PROGRESS

TRAINED_AGENT = "trpo"
"""The expert of a task of a custom group."""
ROUNDING = 1e-9
"""Relative difference of mean returns on another processor."""
MIN_RUNS = 3
"""Of five or more runs, at least this many must beat the floor."""
CURRENT_FILE = REFERENCES / f"{CURRENT}.json"
FIRST = "1"
"""The version whose floors and planner later versions take over."""


def is_open(beaten: Sequence[bool]) -> bool:
    """Whether a task stays open: fewer than three runs beat the floor, or, of under five runs, not all."""
    if len(beaten) < FULL_ENTRY_RUNS:
        return not all(beaten)
    return sum(beaten) < MIN_RUNS


def floor_of(task: Task, results: Results) -> Floor:
    """The floor of one task: the mean return of its better floor agent, and the summaries of both."""
    measurements = [each for each in results if each.task == task and each.agent in FLOOR_AGENTS]
    agents = {
        each.agent: msgspec.structs.replace(summary(returns_of(results[each])), seed=each.agent_seed)
        for each in measurements
    }
    better = max(agents, key=lambda name: agents[name].mean)
    return Floor(
        mean=agents[better].mean,
        agent=better,
        episodes=measurements[0].episodes,
        standard_error=agents[better].standard_error,
        agents=agents,
        fingerprint=fingerprint_of(task),
    )


def _deviation(floor: Floor) -> float:
    """The standard deviation of the floor agent's episodes."""
    return floor.agents[floor.agent].std if floor.agent in floor.agents else 0.0


def with_runs(floor: Floor, measurements: Sequence[Measurement], results: Results) -> model.Task:
    """A custom task, from its floor and the episodes of its training runs or of the planner."""
    parts = [summary(returns_of(results[each])) for each in measurements]
    beaten = [beats_floor(part.mean, part.standard_error, floor.mean, _deviation(floor)) for part in parts]
    mean, error = _over_runs(parts)
    first = measurements[0]
    expert = Expert(mean, error, first.episodes, first.agent, budget=first.budget)
    if first.budget:
        expert.runs = [
            Run(each.run, part.mean, part.std, above)
            for each, part, above in zip(measurements, parts, beaten, strict=True)
        ]
    return model.Task(floor, None, expert) if is_open(beaten) else model.Task(floor, expert)


def _over_runs(parts: Sequence[FloorAgent]) -> tuple[float, float]:
    """The mean over runs and its standard error; of a single run, the error over its episodes."""
    means = [part.mean for part in parts]
    mean = math.fsum(means) / len(means)
    if len(means) == 1:
        return mean, parts[0].standard_error
    deviation = math.sqrt(math.fsum((value - mean) ** 2 for value in means) / (len(means) - 1))
    return mean, deviation / math.sqrt(len(means))


def with_expert(task: Task, floor: Floor, folder: Path = experts.DATA) -> model.Task:
    """A published MuJoCo task, from its floor and the card of its expert; open without a clear expert.

    Raises:
        BenchError: the card is of another definition of the task, or the policy is not the one of the card or
            has other shapes than the task.
    """
    if task.name not in experts.names(folder):
        return model.Task(floor, None)
    card, policy = experts.card(task, folder), experts.load(task, folder)
    if problem := shape_problem(policy, task):
        raise BenchError("other-shapes", f"The expert of {task.name} {problem}.", str(folder))
    seen = card.measurement
    expert = Expert(
        seen.mean, seen.standard_error, seen.episodes, "expert", card.policy, provisional=card.provisional
    )
    is_clear = beats_floor(seen.mean, seen.standard_error, floor.mean, _deviation(floor))
    return model.Task(floor, expert) if is_clear else model.Task(floor, None, expert)


def read_file(path: Path, tasks: Iterable[Task]) -> dict[str, model.Task]:
    """The references by task id of the file at ``path``; none if it does not exist.

    Raises:
        BenchError: the file does not hold references, or its floor of a task is of another definition.
    """
    if not path.exists():
        return {}
    try:
        found = parse_file(path.read_bytes()).tasks
    except (OSError, ValueError) as error:
        message, hint = "The file does not hold references.", "Name another file with --out."
        raise BenchError("malformed-references", message, str(path), hint) from error
    for task in tasks:
        if task.id in found and found[task.id].floor.fingerprint != fingerprint_of(task):
            message = f"The floor of {task.id} was measured with another definition of the task."
            raise BenchError("foreign-fingerprint", message, str(path), "Start a new version with --out.")
    return found


def published(out: Path, jobs: int, folder: Path = experts.DATA, tasks: Iterable[Task] = ()) -> File:
    """The references of the published tasks: floors, the cards of the experts, and the planner.

    Floors in ``out`` stay; others come from version 1, or are measured from their seeds.

    Args:
        out: the path of the references file; its stem is the version.
        jobs: number of worker processes.
        folder: of the experts' files.
        tasks: the tasks; all published ones if empty.

    Raises:
        BenchError: ``out`` is not a references file or has another definition of a task, or an expert is
            refused.
    """
    chosen = list(tasks) or list(TASKS.values())
    first, found = (read_file(path, chosen) for path in (REFERENCES / f"{FIRST}.json", out))
    floors = {task.id: (found | first)[task.id].floor for task in chosen if task.id in found | first}
    floors |= {name: each.floor for name, each in found.items()}
    missing = [task for task in chosen if task.id not in floors]
    results = (
        measure([each for task in missing for each in floor_measurements(task)], jobs) if missing else {}
    )
    content = {}
    for task in chosen:
        floor = floors.get(task.id) or floor_of(task, results)
        if task.base != "Navigation":
            content[task.id] = with_expert(task, floor, folder)
        else:
            planned = first[task.id].expert
            if planned is None:
                raise BenchError("no-reference", f"Version {FIRST} has no planner of {task.id}.", str(out))
            content[task.id] = model.Task(
                floor, Expert(planned.mean, planned.standard_error, planned.episodes, PLANNER)
            )
    return File(2, out.stem, content)


def custom(tasks: Sequence[Task], training: tuple[str, str, Sequence[int]], out: Path, jobs: int) -> File:
    """Measures every task that a references file does not have: its floor, and an agent trained on it alone.

    Finished measurements are stored beside ``out``, so that an interrupted call can be repeated.

    Args:
        tasks: the tasks.
        training: the agent, its training budget, and the training seeds of its runs.
        out: the path of the references file; its stem is the version. Tasks in it stay.
        jobs: number of worker processes.

    Raises:
        BenchError: ``out`` is not a references file or has another definition of a task, or a measurement
            failed.
    """
    found, folder = read_file(out, tasks), out.parent / PROGRESS / out.stem
    floors = {task: floor_measurements(task, folder) for task in tasks if task.id not in found}
    trained = {task: trained_measurements(task, *training, folder) for task in floors}
    results = measure([each for task in floors for each in (*floors[task], *trained[task])], jobs)
    found = read_file(out, tasks)  # another process may have added tasks since
    for task, measurements in trained.items():
        found[task.id] = with_runs(floor_of(task, results), measurements, results)
    return File(2, out.stem, found)


def differences(tasks: Iterable[Task], path: Path, jobs: int, episodes: int = EPISODES) -> list[str]:
    """Measures floors and experts again, from seeds and files, and compares them with a references file.

    Floors and the planner follow from their seeds, but for rounding. Chaotic episodes of a policy differ
    with versions of MuJoCo and BLAS kernels, so that its mean may differ by three standard errors; so may
    everything if less than all episodes are measured.

    Args:
        tasks: the tasks.
        path: the references file.
        jobs: number of worker processes.
        episodes: of every agent: the first ones of 1,000; 100 for a quick check.

    Returns:
        A sentence for every floor and expert that differs.

    Raises:
        BenchError: the file does not have a task, or has another definition of one.
    """
    chosen = list(tasks)
    found = read_file(path, chosen)
    if missing := [task.id for task in chosen if task.id not in found]:
        raise BenchError("no-reference", f"The file has no reference of {missing[0]}.", str(path))
    measurements = [each for task in chosen for each in floor_measurements(task, None, episodes)]
    measurements += [
        planner_measurement(task, None, episodes) for task in chosen if task.base == "Navigation"
    ]
    sentences = []
    for each, outcome in measure(measurements, jobs).items():
        row, again = found[each.task.id], summary(returns_of(outcome))
        stated: FloorAgent | Expert | None = row.floor.agents.get(each.agent)
        if each.agent == PLANNER:
            stated = row.expert
        if stated is None:
            continue
        std = stated.standard_error * EPISODES**0.5
        spread = 3 * std / each.episodes**0.5 if each.episodes < EPISODES else 0.0
        if not math.isclose(again.mean, stated.mean, rel_tol=ROUNDING, abs_tol=spread):
            sentences.append(
                f"{each.task.name}: {each.agent} returns {again.mean:.6g}, not {stated.mean:.6g}"
            )
    for task in chosen:
        expert = found[task.id].expert or found[task.id].attempts or None
        if expert is None or not expert.policy:
            continue
        card, (mean, known, differs) = experts.card(task), measured_again(task, episodes)
        if (card.policy, card.measurement.mean) != (expert.policy, expert.mean):
            sentences.append(f"{task.name}: the expert is not the one of its card")
        if differs:
            sentences.append(f"{task.name}: the expert returns {mean:.6g}, not {known:.6g}")
    return sentences


def parser() -> argparse.ArgumentParser:
    """The command's options."""
    command = argparse.ArgumentParser(
        prog="gym-extensions maintain references",
        description="Write the published references from floors and experts, measure those of custom groups, "
        "or measure references again.",
    )
    command.add_argument(
        "--groups",
        help="comma-separated: TOML files of custom groups to measure (with --out), or groups to check; "
        "all published tasks by default",
    )
    command.add_argument(
        "--budget",
        default=STANDARD_BUDGET,
        choices=list(BUDGETS),
        help=f"of custom groups, training steps per task (default: {STANDARD_BUDGET})",
    )
    command.add_argument(
        "--runs",
        default="1000-1004",
        help="of custom groups, training seeds, at least 1000 (default: 1000-1004)",
    )
    command.add_argument(
        "--agent",
        default=TRAINED_AGENT,
        choices=algorithms.names(),
        help=f"of custom groups, the agent that is trained on each task (default: {TRAINED_AGENT})",
    )
    target = command.add_mutually_exclusive_group()
    target.add_argument(
        "--out",
        type=Path,
        help="the file; its stem is the version's name; floors, and tasks of custom groups, stay as they are "
        "in an existing file (default: the installed references)",
    )
    target.add_argument(
        "--check",
        type=Path,
        metavar="FILE",
        nargs="?",
        const=CURRENT_FILE,
        help="measure the floors and experts in this file again and compare (default: the installed one)",
    )
    command.add_argument("--quick", action="store_true", help=f"check on the first {QUICK} episodes")
    command.add_argument("--jobs", type=int, default=1, help="worker processes (default: 1)")
    return command


@reports_mistakes
def main(argv: list[str] | None = None) -> int:
    """Writes the references file, or checks one; returns the exit status."""
    options = parser().parse_args(argv)
    runs = parse_runs(options.runs)
    for run in runs:
        if run < FIRST_REFERENCE_RUN:
            hint = f"Use numbers from {FIRST_REFERENCE_RUN}; smaller ones are reserved for submissions."
            raise BenchError("bad-run", f"Run {run} is out of range.", "--runs", hint)
    require_positive(options.jobs, "--jobs")
    groups = parse_groups(parse_names(options.groups)) if options.groups else ()
    chosen = list(dict.fromkeys(task for group in groups for task in group.tasks))
    require_published_engine()
    if options.check:
        tasks = chosen or list(TASKS.values())
        different = differences(tasks, options.check, options.jobs, QUICK if options.quick else EPISODES)
        print(f"{len(tasks)} tasks were measured again; {len(different)} numbers differ.")
        for sentence in different:
            print(f"  {sentence}")
        return 1 if different else 0
    out = options.out or CURRENT_FILE
    if out.is_dir():
        raise BenchError("bad-out", "It is a folder.", str(out), "Name a file, such as references.json.")
    if chosen and not options.out:
        hint = "Name a file, such as references.json."
        raise BenchError("bad-out", "Custom groups have a file of their own.", "--out", hint)
    prepare(out.parent)
    if chosen:
        content = custom(chosen, (options.agent, options.budget, runs), out, options.jobs)
    else:
        content = published(out, options.jobs)
    write_bytes(out, msgspec.json.format(msgspec.json.encode(content), indent=1) + b"\n")
    open_tasks = sum(each.expert is None for each in content.tasks.values())
    provisional = sum(bool(each.expert and each.expert.provisional) for each in content.tasks.values())
    counts = f"{len(content.tasks)} tasks, {open_tasks} of them open, {provisional} provisional"
    print(f"The references are in {out}: {counts}.")
    return 0
