"""Measures floors and experts of custom groups: ``gym-extensions maintain references``.

A floor is the better one of random and zero actions. The expert of a custom task is an agent that is trained
on it alone, or the planner in navigation. Every episode follows from its seed, so that anybody can measure
them again.
"""

import argparse
import math
import shutil
import time
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import msgspec

from gym_extensions import files, references
from gym_extensions.baselines import agent_spec, algorithms, cli, generators, submission, workers
from gym_extensions.baselines.algorithms.floors import FLOORS
from gym_extensions.baselines.training import progress, runner
from gym_extensions.baselines.training.jobs import Settings, TrainingJob, parse_groups
from gym_extensions.catalog import protocol
from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.catalog.tasks import Task
from gym_extensions.envs import fingerprinting, make_vec
from gym_extensions.errors import BenchError, reports_mistakes, whole_number
from gym_extensions.references.experts import EPISODES, floor_margin
from gym_extensions.submissions.layout import PROGRESS

PLANNER = "planner"
"""Plans on the map of a navigation task and takes the fewest steps: the expert of these tasks."""
REFERENCE = "reference"
"""Replaces a group's id in the derivation of seeds."""
NUM_ENVS = 100


@dataclass(frozen=True)
class Measurement:
    """An agent of ``FLOORS``, or the planner, on the first of a task's prescribed episodes."""

    task: Task
    agent: str
    episodes: int

    steps = 0
    """It trains nothing."""

    @property
    def title(self) -> str:
        return f"{self.task.id} {self.agent}"

    @property
    def agent_seed(self) -> int:
        return generators.training_seed(protocol.FIRST_REFERENCE_RUN, REFERENCE, self.task.id, self.agent)

    def run(self, listen: progress.Listener) -> list[float]:
        start, returns = time.perf_counter(), list[float]()
        if self.agent == PLANNER:
            from gym_extensions.envs.navigation.planner import oracle_returns

            returns = list(map(float, oracle_returns(self.task, self._seeds(0, self.episodes))))
        else:
            env = make_vec(self.task, min(NUM_ENVS, self.episodes))
            make = algorithms.factory(self.agent)
            agent = make(env.single_observation_space, env.single_action_space, self.agent_seed)
            for first in range(0, self.episodes, env.num_envs):
                outcomes = runner.evaluate(agent, env, self._seeds(first, first + env.num_envs))
                returns += [outcome.return_ for outcome in outcomes]
            returns = returns[: self.episodes]
            env.close()
        result = (self.task.id, len(returns), math.fsum(returns) / len(returns))
        listen(progress.TaskEvaluated(self.title, 1, 0, 0, *result, time.perf_counter() - start))
        return returns

    def _seeds(self, first: int, end: int) -> list[int]:
        return [protocol.evaluation_seed(REFERENCE, self.task.id, episode) for episode in range(first, end)]


def measure(pending: Sequence[Measurement | runner.PendingJob], jobs: int) -> list[list[float]]:
    """The returns of measurements and of training jobs, which run in worker processes; shows the progress.

    Raises ``BenchError`` if one failed. The finished stages of training jobs are stored.
    """
    results: dict[int, list[float]] = {}
    failures: dict[str, workers.Failure] = {}
    with progress.open_bars() as show:
        show(progress.TrainingStarted({each.title: each.steps for each in pending}))
        for index, outcome in workers.run(pending, show, jobs):
            title = pending[index].title
            if isinstance(outcome, workers.Failure):
                failures[title] = outcome
                show(progress.JobFailed(title, outcome.cause))
            elif isinstance(pending[index], runner.PendingJob):
                results[index] = [each.return_ for record in outcome for each in record.episodes]
            else:
                results[index] = outcome
    if failures:
        raise workers.jobs_failed(failures, len(pending), "Finished training is stored; repeat the command.")
    return [results[index] for index in range(len(pending))]


def floor_measurements(task: Task, episodes: int = EPISODES) -> list[Measurement]:
    """The measurements of a task's floor."""
    return [Measurement(task, agent, episodes) for agent in FLOORS]


def summary(returns: Sequence[float]) -> references.FloorAgent:
    """Mean, population standard deviation and standard error of the mean of episode returns."""
    mean = math.fsum(returns) / len(returns)
    std = math.sqrt(math.fsum((value - mean) ** 2 for value in returns) / len(returns))
    return references.FloorAgent(mean, std, std / math.sqrt(len(returns)))


def is_open(beaten: Sequence[bool]) -> bool:
    """Whether a task stays open: fewer than three runs beat the floor, or, of under five runs, not all."""
    return sum(beaten) < 3 if len(beaten) >= protocol.FULL_SUBMISSION_RUNS else not all(beaten)


def floor_of(returns: Mapping[Measurement, Sequence[float]]) -> references.Floor:
    """The floor of one task: the mean return of its better floor agent, and the summaries of both."""
    agents = {
        each.agent: msgspec.structs.replace(summary(values), seed=each.agent_seed)
        for each, values in returns.items()
    }
    name, better = max(agents.items(), key=lambda item: item[1].mean)
    first = next(iter(returns))
    fingerprint = fingerprinting.fingerprint_of(first.task)
    return references.Floor(better.mean, name, first.episodes, better.standard_error, agents, fingerprint)


def is_above(floor: references.Floor, mean: float, standard_error: float) -> bool:
    """Whether a mean return is above a floor by more than chance."""
    deviation = floor.agents[floor.agent].std if floor.agent in floor.agents else 0.0
    return mean - floor.mean > floor_margin(standard_error, deviation)


def with_runs(
    floor: references.Floor, runs: Mapping[int, Sequence[float]], agent: str, budget: str = ""
) -> references.Reference:
    """A custom task, from its floor and the returns of its training runs, or of the planner, by run."""
    parts = {run: summary(returns) for run, returns in runs.items()}
    beaten = {run: is_above(floor, part.mean, part.standard_error) for run, part in parts.items()}
    means = [part.mean for part in parts.values()]
    mean, error = math.fsum(means) / len(means), parts[next(iter(parts))].standard_error
    if len(means) > 1:
        deviation = math.sqrt(math.fsum((value - mean) ** 2 for value in means) / (len(means) - 1))
        error = deviation / math.sqrt(len(means))
    expert = references.Expert(mean, error, len(next(iter(runs.values()))), agent, budget=budget)
    if budget:
        rows = ((run, part.mean, part.std, beaten[run]) for run, part in parts.items())
        expert.runs = [references.MeasuredRun(*row) for row in rows]
    if is_open(list(beaten.values())):
        return references.Reference(floor, None, expert)
    return references.Reference(floor, expert)


def read_file(path: Path, tasks: Iterable[Task]) -> dict[str, references.Reference]:
    """The references by task id of the file at ``path``; none if it does not exist.

    Raises:
        BenchError: the file does not hold references, or its floor of a task is of another definition.
    """
    if not path.exists():
        return {}
    found = dict(references.read_references(path).tasks)
    for task in tasks:
        if task.id in found and found[task.id].floor.fingerprint != fingerprinting.fingerprint_of(task):
            message = f"The floor of {task.id} was measured with another definition of the task."
            raise BenchError("foreign-fingerprint", message, str(path), "Start a new version with --out.")
    return found


def measured_floors(tasks: Sequence[Task], jobs: int) -> dict[str, references.Floor]:
    """The floors of tasks by id."""
    pending = [each for task in tasks for each in floor_measurements(task)]
    returns = dict(zip(pending, measure(pending, jobs), strict=True)) if pending else {}
    return {task.id: floor_of({each: returns[each] for each in floor_measurements(task)}) for task in tasks}


def custom(
    groups: Sequence[TaskGroup], agent: str, budget: str, runs: Sequence[int], *, out: Path, jobs: int
) -> references.File:
    """Measures every task without a reference in the file: its floor, and an agent trained on it alone.

    Tasks with a published reference, which is never replaced, are left out. The agents are trained as in the
    protocol ``single``, with seeds that no submission has, and evaluated on the 20 prescribed episodes of the
    group. Finished stages are stored beside ``out``, so that an interrupted call can be repeated.

    Args:
        groups: the groups of the tasks.
        agent, budget, runs: what is trained, for how long, and the training seeds of its runs.
        out: the path of the references file; its stem is the version. Tasks in it stay.
        jobs: number of worker processes.

    Raises:
        BenchError: ``out`` is not a references file or has another definition of a task, or a measurement
            failed.
    """
    group_of = {task.id: group for group in groups for task in group.tasks}
    tasks = {task.id: task for group in groups for task in group.tasks}
    known = {*references.load_references().tasks, *read_file(out, tasks.values())}
    missing = [task for task in tasks.values() if task.id not in known]
    pending: dict[tuple[str, int], Measurement | runner.PendingJob] = {}  # by task and run
    for task in missing:
        if task.base == "Navigation":
            pending[task.id, protocol.FIRST_REFERENCE_RUN] = Measurement(task, PLANNER, EPISODES)
            continue
        group = group_of[task.id]
        settings = Settings(agent_spec.AgentSpec.of(agent, [(group, "single")]), protocol.budget(budget))
        for run in runs:
            job = TrainingJob(group, "single", run, group.tasks.index(task))
            pending[task.id, run] = runner.PendingJob(job, settings, out.parent / PROGRESS / out.stem)
    floors = measured_floors(missing, jobs)
    returns = dict(zip(pending, measure(list(pending.values()), jobs), strict=True))
    found = read_file(out, missing)  # another process may have added tasks since
    for task in missing:
        of_task = {run: values for (id_, run), values in returns.items() if id_ == task.id}
        names = (PLANNER, "") if task.base == "Navigation" else (agent, budget)
        found[task.id] = with_runs(floors[task.id], of_task, *names)
    return references.File(2, out.stem, found)


def write_file(content: references.File, out: Path) -> None:
    """Writes a references file, and prints what it holds."""
    files.write_bytes(out, msgspec.json.format(msgspec.json.encode(content), indent=1) + b"\n")
    open_tasks = sum(each.expert is None for each in content.tasks.values())
    provisional = sum(bool(each.expert and each.expert.provisional) for each in content.tasks.values())
    unscored = f"{open_tasks} open (no expert clearly above the floor, so no score)"
    counts = f"{len(content.tasks)} tasks, {provisional} provisional, {unscored}"
    print(f"The references are in {out}: {counts}.")


def parser() -> argparse.ArgumentParser:
    """The command's options."""
    command = argparse.ArgumentParser(
        prog="gym-extensions maintain references",
        description="Measure the floors and experts of custom groups, whose scores need them.",
    )
    add = command.add_argument
    file = "the file to write; its name without .json is the name of the version. Tasks in it stay"
    add("--groups", required=True, help="comma-separated: TOML files of custom groups")
    add("--out", required=True, type=Path, help=file)
    steps = "training steps per task (default: %(default)s)"
    add("--budget", default=protocol.STANDARD_BUDGET, choices=list(protocol.BUDGETS), help=steps)
    add("--runs", default="1000-1004", help="training seeds from 1000 on (default: %(default)s)")
    trained = "agent that is trained on each task (default: %(default)s)"
    add("--agent", default="trpo", choices=algorithms.names(), help=trained)
    add("--jobs", type=int, default=1, help="worker processes (default: 1)")
    return command


@reports_mistakes
def main(argv: list[str] | None = None) -> int:
    """Measures the tasks that a references file lacks, and writes it; returns the exit status."""
    options = parser().parse_args(argv)
    runs, out = cli.parse_runs(options.runs), options.out
    for run in runs:
        if run < (first := protocol.FIRST_REFERENCE_RUN):
            hint = f"Use numbers from {first}; smaller ones are reserved for submissions."
            raise BenchError("bad-run", f"Run {run} is out of range.", "--runs", hint)
    whole_number("jobs", options.jobs, "bad-jobs", "--jobs")
    groups = parse_groups(cli.parse_names(options.groups))
    fingerprinting.require_published_engine()
    if out.is_dir():
        raise BenchError("bad-out", "It is a folder.", str(out), "Name a file, such as references.json.")
    if out.resolve().parent == references.path_of().parent:
        message = "It is one of the published references, which never change."
        raise BenchError("bad-out", message, str(out), "Name a file outside the package.")
    submission.prepare(out.parent)
    write_file(custom(groups, options.agent, options.budget, runs, out=out, jobs=options.jobs), out)
    shutil.rmtree(out.parent / PROGRESS / out.stem, ignore_errors=True)
    with suppress(OSError):  # there are unfinished measurements for other files
        (out.parent / PROGRESS).rmdir()
    return 0
