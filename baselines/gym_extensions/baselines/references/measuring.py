"""Measures the references that normalize scores, and compares them with a file.

The published file has a floor of every task, the better one of random and zero actions, and its expert: a
policy of :mod:`gym_extensions.references.experts`, or the planner in navigation. In a file of custom groups
the expert is an agent that is trained on the task alone. Every episode follows from its seed, so that anybody
can measure them again.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec

from gym_extensions.baselines import algorithms, workers
from gym_extensions.baselines.agent_spec import AgentSpec
from gym_extensions.baselines.experts.candidates import measured_again
from gym_extensions.baselines.generators import training_seed
from gym_extensions.baselines.training import events
from gym_extensions.baselines.training.evaluation import evaluate
from gym_extensions.baselines.training.jobs import Settings, TrainingJob
from gym_extensions.baselines.training.progress import open_bars
from gym_extensions.baselines.training.runner import PendingJob
from gym_extensions.baselines.workers import Failure, Runnable, jobs_failed
from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.catalog.protocol import (
    FIRST_REFERENCE_RUN,
    FULL_SUBMISSION_RUNS,
    budget as budget_named,
    evaluation_seed,
)
from gym_extensions.catalog.tasks import TASKS, Task
from gym_extensions.envs import make_vec
from gym_extensions.envs.fingerprinting import fingerprint_of
from gym_extensions.errors import BenchError
from gym_extensions.references import (
    Expert,
    File,
    Floor,
    FloorAgent,
    MeasuredReference,
    MeasuredRun,
    experts,
    parse_file,
    path_of,
)
from gym_extensions.references.experts import EPISODES, floor_margin
from gym_extensions.submissions.layout import PROGRESS

FLOOR_AGENTS = ("random", "zero")
PLANNER = "planner"
"""Plans on the map of a navigation task and takes the fewest steps: the expert of these tasks."""
REFERENCE = "reference"
"""Replaces a group's id in the derivation of seeds."""
NUM_ENVS = 100
ROUNDING = 1e-9
"""Relative difference of mean returns on another processor."""
MIN_RUNS = 3
"""Of five or more runs, at least this many must beat the floor."""
FIRST = "1"
"""The version whose floors and planner later versions take over."""


@dataclass(frozen=True)
class Measurement:
    """An agent of ``FLOOR_AGENTS``, or the planner, on the first of a task's prescribed episodes."""

    task: Task
    agent: str
    episodes: int

    @property
    def plan(self) -> events.JobPlan:
        return events.JobPlan(f"{self.task.id} {self.agent}", (events.StagePlan(1, 0, self.episodes),))

    @property
    def agent_seed(self) -> int:
        return training_seed(FIRST_REFERENCE_RUN, REFERENCE, self.task.id, self.agent)

    def run(self, listen: events.Listener) -> list[float]:
        start, returns = time.perf_counter(), list[float]()
        if self.agent == PLANNER:
            from gym_extensions.envs.navigation.planner import oracle_returns

            returns = list(map(float, oracle_returns(self.task, self._seeds(0, self.episodes))))
        else:
            env = make_vec(self.task, min(NUM_ENVS, self.episodes))
            make = algorithms.factory(self.agent)
            agent = make(env.single_observation_space, env.single_action_space, self.agent_seed)
            for first in range(0, self.episodes, env.num_envs):
                outcomes = evaluate(agent, env, self._seeds(first, first + env.num_envs))
                returns += [outcome.return_ for outcome in outcomes]
            returns = returns[: self.episodes]
            env.close()
        result = (self.task.id, len(returns), math.fsum(returns) / len(returns))
        listen(events.TaskEvaluated(self.plan.title, 1, 0, 0, *result, time.perf_counter() - start))
        return returns

    def _seeds(self, first: int, end: int) -> list[int]:
        return [evaluation_seed(REFERENCE, self.task.id, episode) for episode in range(first, end)]


def measure(pending: Sequence[Measurement | PendingJob], jobs: int) -> list[list[float]]:
    """The returns of measurements and of training jobs, which run in worker processes; shows the progress.

    Raises ``BenchError`` if one failed. The finished stages of training jobs are stored.
    """
    results: dict[int, list[float]] = {}
    failures: dict[str, Failure] = {}
    runnable: Sequence[Runnable[Any]] = pending
    with open_bars() as (_, show):
        show(events.TrainingStarted(tuple(each.plan for each in pending), jobs))
        for index, outcome in workers.run(runnable, show, jobs):
            title = pending[index].plan.title
            if isinstance(outcome, Failure):
                failures[title] = outcome
                show(events.JobFailed(title, outcome.cause))
            elif isinstance(pending[index], PendingJob):
                results[index] = [each.return_ for record in outcome for each in record.episodes]
            else:
                results[index] = outcome
    if failures:
        raise jobs_failed(failures, len(pending), "Finished training is stored; repeat the command.")
    return [results[index] for index in range(len(pending))]


def floor_measurements(task: Task, episodes: int = EPISODES) -> list[Measurement]:
    """The measurements of a task's floor."""
    return [Measurement(task, agent, episodes) for agent in FLOOR_AGENTS]


def summary(returns: Sequence[float]) -> FloorAgent:
    """Mean, population standard deviation and standard error of the mean of episode returns."""
    mean = math.fsum(returns) / len(returns)
    std = math.sqrt(math.fsum((value - mean) ** 2 for value in returns) / len(returns))
    return FloorAgent(mean, std, std / math.sqrt(len(returns)))


def is_open(beaten: Sequence[bool]) -> bool:
    """Whether a task stays open: fewer than three runs beat the floor, or, of under five runs, not all."""
    if len(beaten) < FULL_SUBMISSION_RUNS:
        return not all(beaten)
    return sum(beaten) < MIN_RUNS


def floor_of(returns: Mapping[Measurement, Sequence[float]]) -> Floor:
    """The floor of one task: the mean return of its better floor agent, and the summaries of both."""
    agents = {
        each.agent: msgspec.structs.replace(summary(values), seed=each.agent_seed)
        for each, values in returns.items()
    }
    name, better = max(agents.items(), key=lambda item: item[1].mean)
    first = next(iter(returns))
    fingerprint = fingerprint_of(first.task)
    return Floor(better.mean, name, first.episodes, better.standard_error, agents, fingerprint)


def _is_above(floor: Floor, mean: float, standard_error: float) -> bool:
    deviation = floor.agents[floor.agent].std if floor.agent in floor.agents else 0.0
    return mean - floor.mean > floor_margin(standard_error, deviation)


def with_runs(
    floor: Floor, runs: Mapping[int, Sequence[float]], agent: str, budget: str = ""
) -> MeasuredReference:
    """A custom task, from its floor and the returns of its training runs, or of the planner, by run."""
    parts = {run: summary(returns) for run, returns in runs.items()}
    beaten = {run: _is_above(floor, part.mean, part.standard_error) for run, part in parts.items()}
    means = [part.mean for part in parts.values()]
    mean, error = math.fsum(means) / len(means), parts[next(iter(parts))].standard_error
    if len(means) > 1:
        deviation = math.sqrt(math.fsum((value - mean) ** 2 for value in means) / (len(means) - 1))
        error = deviation / math.sqrt(len(means))
    expert = Expert(mean, error, len(next(iter(runs.values()))), agent, budget=budget)
    if budget:
        expert.runs = [MeasuredRun(run, part.mean, part.std, beaten[run]) for run, part in parts.items()]
    is_unbeaten = is_open(list(beaten.values()))
    return MeasuredReference(floor, None, expert) if is_unbeaten else MeasuredReference(floor, expert)


def with_expert(task: Task, floor: Floor, folder: Path = experts.DATA) -> MeasuredReference:
    """A published MuJoCo task, from its floor and the card of its expert; open without a clear expert.

    Raises ``BenchError`` if the card is of another definition of the task, or the policy is not the one of
    the card.
    """
    if task.bare_name not in experts.names(folder):
        return MeasuredReference(floor, None)
    card = experts.card(task, folder)
    experts.load(task, folder)  # raises if the policy is another
    mean, error, count = card.measurement.mean, card.measurement.standard_error, card.measurement.episodes
    expert = Expert(mean, error, count, "expert", card.policy, provisional=card.provisional)
    return (
        MeasuredReference(floor, expert)
        if _is_above(floor, mean, error)
        else MeasuredReference(floor, None, expert)
    )


def read_file(path: Path, tasks: Iterable[Task]) -> dict[str, MeasuredReference]:
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

    Floors in ``out``, whose stem is the version, stay; others come from version 1, or are measured from their
    seeds in ``jobs`` processes. ``folder`` has the experts' files. Without ``tasks``, all published ones.

    Raises:
        BenchError: ``out`` is not a references file or has another definition of a task, or an expert is
            refused.
    """
    chosen = list(tasks) or list(TASKS.values())
    first, found = (read_file(path, chosen) for path in (path_of(FIRST), out))
    floors = {name: each.floor for name, each in (first | found).items()}
    floors |= measured_floors([task for task in chosen if task.id not in floors], jobs)
    content = {}
    for task in chosen:
        floor = floors[task.id]
        if task.base != "Navigation":
            content[task.id] = with_expert(task, floor, folder)
        else:
            planned = first[task.id].expert
            assert planned is not None, f"version {FIRST} has a planner of every navigation task"
            expert = Expert(planned.mean, planned.standard_error, planned.episodes, PLANNER)
            content[task.id] = MeasuredReference(floor, expert)
    return File(2, out.stem, content)


def measured_floors(tasks: Sequence[Task], jobs: int) -> dict[str, Floor]:
    """The floors of tasks by id."""
    pending = [each for task in tasks for each in floor_measurements(task)]
    returns = dict(zip(pending, measure(pending, jobs), strict=True)) if pending else {}
    return {task.id: floor_of({each: returns[each] for each in floor_measurements(task)}) for task in tasks}


def custom(
    groups: Sequence[TaskGroup], training: tuple[str, str, Sequence[int]], out: Path, jobs: int
) -> File:
    """Measures every task that a references file does not have: its floor, and an agent trained on it alone.

    The agents are trained and evaluated as in the protocol ``single``, by other seeds than those of
    submissions. Finished stages are stored beside ``out``, so that an interrupted call can be repeated.

    Args:
        groups: the groups of the tasks.
        training: the agent, its training budget, and the training seeds of its runs.
        out: the path of the references file; its stem is the version. Tasks in it stay.
        jobs: number of worker processes.

    Raises:
        BenchError: ``out`` is not a references file or has another definition of a task, or a measurement
            failed.
    """
    agent, budget, runs = training
    tasks = {task.id: (group, index) for group in groups for index, task in enumerate(group.tasks)}
    known = read_file(out, [group.tasks[index] for group, index in tasks.values()])
    missing = [group.tasks[index] for id_, (group, index) in tasks.items() if id_ not in known]
    pending: dict[tuple[str, int], Measurement | PendingJob] = {}
    for task in missing:
        group, index = tasks[task.id]
        if task.base == "Navigation":
            pending[task.id, FIRST_REFERENCE_RUN] = Measurement(task, PLANNER, EPISODES)
            continue
        settings = Settings(AgentSpec.of(agent, [(group, "single")]), budget_named(budget))
        for run in runs:
            job = TrainingJob(group, "single", run, index)
            pending[task.id, run] = PendingJob(job, settings, out.parent / PROGRESS / out.stem)
    floors = measured_floors(missing, jobs)
    returns = dict(zip(pending, measure(list(pending.values()), jobs), strict=True))
    found = read_file(out, missing)  # another process may have added tasks since
    for task in missing:
        of_task = {run: values for (id_, run), values in returns.items() if id_ == task.id}
        names = (PLANNER, "") if task.base == "Navigation" else (agent, budget)
        found[task.id] = with_runs(floors[task.id], of_task, *names)
    return File(2, out.stem, found)


def differences(tasks: Iterable[Task], path: Path, jobs: int, episodes: int = EPISODES) -> list[str]:
    """Measures floors and experts again, from seeds and files, and compares them with a references file.

    Floors and the planner follow from their seeds, but for rounding. Chaotic episodes of a policy differ
    with versions of MuJoCo and BLAS kernels, so that its mean may differ by three standard errors; so may
    everything if less than all episodes are measured.

    Of every agent the first ``episodes`` of 1,000 are used. Returns a sentence for each that differs.

    Raises ``BenchError`` if the file does not have a task, or has another definition of one.
    """
    chosen = list(tasks)
    found = read_file(path, chosen)
    if missing := [task.id for task in chosen if task.id not in found]:
        hint = "Choose other --groups, or another file."
        raise BenchError("no-reference", f"The file has no reference of {missing[0]}.", str(path), hint)
    measurements = [each for task in chosen for each in floor_measurements(task, episodes)]
    measurements += [Measurement(task, PLANNER, episodes) for task in chosen if task.base == "Navigation"]
    sentences = []
    for each, returns in zip(measurements, measure(measurements, jobs), strict=True):
        row, again = found[each.task.id], summary(returns)
        stated: FloorAgent | Expert | None = row.floor.agents.get(each.agent)
        if each.agent == PLANNER:
            stated = row.expert
        if stated is None:
            continue
        std = stated.standard_error * EPISODES**0.5
        spread = 3 * std / each.episodes**0.5 if each.episodes < EPISODES else 0.0
        if not math.isclose(again.mean, stated.mean, rel_tol=ROUNDING, abs_tol=spread):
            numbers = f"{again.mean:.6g}, not {stated.mean:.6g}"
            sentences.append(f"{each.task.name}: {each.agent} returns {numbers}")
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
