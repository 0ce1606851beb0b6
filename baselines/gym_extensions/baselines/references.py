"""Measures floors and ceilings, and writes the file that normalizes scores.

The floor of a task is the mean return of the better one of random and zero actions. The ceiling is the mean
return of the reference agent trained on this task alone, or of the oracle in navigation. Every episode
follows from its seed, so that anybody can measure them again.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import math
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from gym_extensions.baselines import algorithms
from gym_extensions.baselines.agent import Agent, VectorEnv
from gym_extensions.baselines.agent_checks import card_of
from gym_extensions.baselines.entry import prepare
from gym_extensions.baselines.execution.workers import Failure, Workers, jobs_failed
from gym_extensions.baselines.progress import open_bars
from gym_extensions.baselines.training.evaluation import evaluate
from gym_extensions.baselines.training.events import (
    BatchTrained,
    JobFailed,
    JobPlan,
    Listener,
    StagePlan,
    TaskEvaluated,
    TrainingStarted,
)
from gym_extensions.baselines.training.jobs import Settings, job_versions, training_seed
from gym_extensions.baselines.training.recorder import Batch, Recorder
from gym_extensions.baselines.training.request import parse_groups, parse_names, parse_runs, require_positive
from gym_extensions.catalog.protocol import (
    BUDGETS,
    FIRST_REFERENCE_RUN,
    FULL_ENTRY_RUNS,
    STANDARD_BUDGET,
    budget,
    evaluation_seed,
)
from gym_extensions.catalog.tasks import Task
from gym_extensions.envs import make_vec
from gym_extensions.envs.fingerprint import fingerprint_of, require_published_engine
from gym_extensions.errors import BenchError, reports_mistakes
from gym_extensions.files import write_text
from gym_extensions.rollouts.layout import PROGRESS
from gym_extensions.rollouts.tables import Episode

FORMAT = 1
FLOOR_AGENTS = ("random", "zero")
CEILING_AGENT = "trpo"
ORACLE = "oracle"
"""Plans on the map of a navigation task and takes the fewest steps: the ceiling of these tasks."""
FLOOR_EPISODES, CEILING_EPISODES = 1000, 100
NUM_ENVS = 100
ROUNDING = 1e-9
"""Relative difference of mean returns on another processor."""
ARRIVAL_REWARD = 10.0
REFERENCE = "reference"
"""Replaces a group's id in the derivation of seeds."""
SEED_NAMES = {"trpo-2017": "trpo"}
"""Agents that were renamed after references were measured. Their seeds are derived from the earlier name."""
MIN_ERRORS, MIN_DEVIATIONS = 5.0, 1.0
"""A run beats the floor by at least this many standard errors and standard deviations."""
MIN_RUNS = 3
"""Of five or more runs, at least this many must beat the floor."""
FLOOR_COLUMNS = ("agent", "episode", "seed", "length", "return", "terminated")
CEILING_COLUMNS = (
    *("run", "stage", "task", "episode", "seed", "length", "return", "terminated", "success"),
    "fingerprint",
)
"""The columns of the logs whose digests a references file states. The logs themselves are not kept."""


@dataclass(frozen=True)
class Measurement:
    """An agent on a task: the run, the number of episodes and the training budget (untrained if empty).

    A finished measurement is stored in ``folder``. It is not made again, unless its agent's settings or the
    versions of packages differ.
    """

    task: Task
    agent: str
    run: int
    episodes: int
    budget: str = ""
    folder: Path | None = None

    @property
    def title(self) -> str:
        """A readable name."""
        return f"{self.task.id} {self.agent}" + (f" run {self.run}" if self.budget else "")

    @property
    def steps(self) -> int:
        """Training steps."""
        return budget(self.budget).batches * budget(self.budget).batch_steps if self.budget else 0

    @property
    def agent_seed(self) -> int:
        """The seed of the agent."""
        return training_seed(self.run, REFERENCE, self.task.id, SEED_NAMES.get(self.agent, self.agent))

    @property
    def plan(self) -> JobPlan:
        """The work."""
        return JobPlan(self.title, (StagePlan(1, self.steps, self.episodes),))

    def seeds(self, episodes: Iterable[int]) -> list[int]:
        """The prescribed seeds of episodes."""
        return [evaluation_seed(REFERENCE, self.task.id, episode) for episode in episodes]

    def run_episodes(self, listen: Listener) -> list[Episode]:
        """Trains the agent if it has a budget, and evaluates it with the prescribed seeds."""
        if self.agent == ORACLE:
            return self._oracle_episodes()
        env = make_vec(self.task, min(NUM_ENVS, self.episodes))
        agent = self._agent(env)
        if self.budget:
            self._train(agent, listen)
        start, episodes = time.perf_counter(), list[Episode]()
        for first in range(0, self.episodes, env.num_envs):
            numbers = range(first, first + env.num_envs)
            seeds = self.seeds(numbers)
            for number, seed, outcome in zip(numbers, seeds, evaluate(agent, env, seeds), strict=True):
                episodes.append(Episode(1, self.task.id, number, seed, *outcome))
        env.close()
        episodes = episodes[: self.episodes]
        mean_return = sum(_returns(episodes)) / len(episodes)
        where = (self.title, 1, self.steps, self.steps, self.task.id)
        listen(TaskEvaluated(*where, len(episodes), mean_return, time.perf_counter() - start))
        return episodes

    def run_or_load(self, listen: Listener) -> list[Episode]:
        """The episodes of the stored measurement, or of a new one, which is then stored."""
        if self.folder is None:
            return self.run_episodes(listen)
        name = f"{self.task.name}-{self.agent}-{self.budget or 'untrained'}-{self.run}-{self.episodes}.json"
        path, provenance = self.folder / name, self._provenance()
        if path.exists():
            stored: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
            if stored["settings"] == json.loads(json.dumps(provenance)):
                return [Episode(**each) for each in stored["episodes"]]
        episodes = self.run_episodes(listen)
        content = {"settings": provenance, "episodes": [asdict(episode) for episode in episodes]}
        write_text(path, json.dumps(content) + "\n")
        return episodes

    def _provenance(self) -> dict[str, Any]:
        """What the result depends on: the task, the agent's settings, and the versions of packages."""
        settings: dict[str, Any] = {"title": self.title, "fingerprint": fingerprint_of(self.task)}
        if self.agent == ORACLE:
            return settings | {"versions": job_versions()}
        env = make_vec(self.task, 1)
        card = card_of(self._agent(env), self.agent)
        env.close()
        versions = job_versions(card.packages)
        return settings | {"versions": versions, "hyperparameters": dict(card.hyperparameters)}

    def _agent(self, env: VectorEnv) -> Agent:
        make = algorithms.factory(self.agent)
        return make(env.single_observation_space, env.single_action_space, self.agent_seed)

    def _train(self, agent: Agent, listen: Listener) -> None:
        plan = budget(self.budget)
        env = make_vec(self.task, Settings(self.agent, plan.name).num_envs_for(1))

        def report(batch: Batch) -> None:
            speed = batch.steps / max(batch.seconds, 1e-9)
            listen(
                BatchTrained(self.title, 1, batch.step, batch.step, batch.mean_return, speed, batch.seconds)
            )

        recorder = Recorder(
            env,
            [self.task.id],
            steps=self.steps,
            batch_steps=plan.batch_steps,
            seed=training_seed(self.run, REFERENCE, self.task.id, "training"),
            report=report,
        )
        agent.learn(recorder, self.steps)
        env.close()

    def _oracle_episodes(self) -> list[Episode]:
        from gym_extensions.envs.navigation.planner import oracle_returns

        episodes, seeds = [], self.seeds(range(self.episodes))
        for number, (seed, return_) in enumerate(zip(seeds, oracle_returns(self.task, seeds), strict=True)):
            length = round(ARRIVAL_REWARD - return_)  # no collisions: −1 per step, and the reward of arrival
            episodes.append(Episode(1, self.task.id, number, seed, length, float(return_), True, True))
        return episodes


@dataclass(frozen=True)
class PendingMeasurement:
    """A measurement that a worker process can run."""

    measurement: Measurement

    def run(self, listen: Listener) -> list[Episode]:
        """The measurement's episodes."""
        return self.measurement.run_or_load(listen)


Results = Mapping[Measurement, Sequence[Episode]]


def floor_measurements(task: Task, folder: Path | None = None) -> dict[str, Measurement]:
    """The measurements of a task's floor, by agent."""
    return {
        agent: Measurement(task, agent, FIRST_REFERENCE_RUN, FLOOR_EPISODES, folder=folder)
        for agent in FLOOR_AGENTS
    }


def ceiling_measurements(
    task: Task, budget: str, runs: Sequence[int], agent: str = CEILING_AGENT, folder: Path | None = None
) -> list[Measurement]:
    """The measurements of a task's ceiling: the reference runs, or the oracle in navigation."""
    if task.base == "Navigation":
        return [Measurement(task, ORACLE, FIRST_REFERENCE_RUN, FLOOR_EPISODES, folder=folder)]
    return [Measurement(task, agent, run, CEILING_EPISODES, budget, folder) for run in runs]


def summary(returns: Sequence[float]) -> dict[str, float]:
    """Mean, population standard deviation and standard error of the mean of episode returns."""
    mean = math.fsum(returns) / len(returns)
    std = math.sqrt(math.fsum((value - mean) ** 2 for value in returns) / len(returns))
    return {"mean": mean, "std": std, "standard_error": std / math.sqrt(len(returns))}


def beats_floor(run: Mapping[str, float], floor: Mapping[str, float]) -> bool:
    """Whether a run is above the floor by five standard errors and one standard deviation of its episodes."""
    difference = run["mean"] - floor["mean"]
    error = math.hypot(run["standard_error"], floor["standard_error"])
    clear = difference >= MIN_ERRORS * error and difference >= MIN_DEVIATIONS * run["std"]
    return clear and difference > 0


def is_unsolved(beaten: Sequence[bool]) -> bool:
    """Whether a task is unsolved: fewer than three runs beat the floor, or, of under five runs, not all."""
    if len(beaten) < FULL_ENTRY_RUNS:
        return not all(beaten)
    return sum(beaten) < MIN_RUNS


def floor_of(task: Task, results: Results) -> dict[str, Any]:
    """The floor of one task: the mean return of its better floor agent, and the summaries of both."""
    measurements = [each for each in results if each.task == task and each.agent in FLOOR_AGENTS]
    agents = {
        each.agent: summary(_returns(results[each])) | {"seed": each.agent_seed} for each in measurements
    }
    better = max(agents, key=lambda name: agents[name]["mean"])
    lines = [(each.agent, *_cells(episode)[2:-1]) for each in measurements for episode in results[each]]
    return {
        "mean": agents[better]["mean"],
        "agent": better,
        "budget": None,
        "run": FIRST_REFERENCE_RUN,
        "episodes": FLOOR_EPISODES,
        "standard_error": agents[better]["standard_error"],
        "agents": agents,
        "fingerprint": fingerprint_of(task),
        "log_sha256": _digest(FLOOR_COLUMNS, lines),
    }


def references_of(
    floor: Mapping[str, Any], measurements: Sequence[Measurement], results: Results
) -> dict[str, Any]:
    """The references of one task, from its floor and the episodes of its reference runs."""
    summaries = {each.run: summary(_returns(results[each])) for each in measurements}
    runs: list[dict[str, Any]] = [
        {"run": run, "mean": each["mean"], "std": each["std"], "beats_floor": beats_floor(each, floor)}
        for run, each in sorted(summaries.items())
    ]
    mean, error = _over_runs([summaries[run] for run in sorted(summaries)])
    fingerprint = fingerprint_of(measurements[0].task)
    lines = [
        (str(each.run), *_cells(episode), fingerprint) for each in measurements for episode in results[each]
    ]
    ceiling = {
        "mean": mean,
        "agent": measurements[0].agent,
        "budget": measurements[0].budget,
        "episodes": measurements[0].episodes,
        "standard_error": error,
        "runs": runs,
        "log_sha256": _digest(CEILING_COLUMNS, lines),
    }
    unsolved = is_unsolved([run["beats_floor"] for run in runs])
    references = {"floor": dict(floor), "ceiling": None if unsolved else ceiling, "unsolved": unsolved}
    return references | ({"attempts": ceiling} if unsolved else {})


def _over_runs(summaries: Sequence[Mapping[str, float]]) -> tuple[float, float]:
    """The mean over runs and its standard error; of a single run, the error over its episodes."""
    means = [summary["mean"] for summary in summaries]
    mean = math.fsum(means) / len(means)
    if len(means) == 1:
        return mean, summaries[0]["standard_error"]
    deviation = math.sqrt(math.fsum((value - mean) ** 2 for value in means) / (len(means) - 1))
    return mean, deviation / math.sqrt(len(means))


def _returns(episodes: Sequence[Episode]) -> list[float]:
    return [episode.return_ for episode in episodes]


def _cells(episode: Episode) -> tuple[str, ...]:
    """The cells of an episode as in the log of a run."""
    names = {True: "true", False: "false", None: ""}
    first = (episode.stage, episode.task, episode.episode, episode.seed, episode.length)
    last = (repr(episode.return_), names[episode.terminated], names[episode.success])
    return (*map(str, first), *last)


def _digest(columns: Sequence[str], lines: Iterable[Sequence[str]]) -> str:
    """The SHA-256 of a CSV file."""
    text = "".join(",".join(cells) + "\n" for cells in [columns, *lines])
    return hashlib.sha256(text.encode()).hexdigest()


def existing_tasks(path: Path, tasks: Iterable[Task]) -> dict[str, dict[str, Any]]:
    """The references by task id of the file at ``path``; none if it does not exist.

    Raises:
        BenchError: the file does not hold references, or its floor of a task is of another definition.
    """
    if not path.exists():
        return {}
    try:
        document = json.loads(path.read_bytes())
        found: dict[str, dict[str, Any]] = document["tasks"]
        if document["format"] != FORMAT:
            raise ValueError(document["format"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        message, hint = "The file does not hold references.", "Name another file with --out."
        raise BenchError("malformed-references", message, str(path), hint) from error
    for task in tasks:
        if task.id in found and found[task.id]["floor"]["fingerprint"] != fingerprint_of(task):
            message = f"The floor of {task.id} was measured with another definition of the task."
            raise BenchError("foreign-fingerprint", message, str(path), "Start a new version with --out.")
    return found


def measure(measurements: Sequence[Measurement], jobs: int) -> dict[Measurement, list[Episode]]:
    """Makes measurements in worker processes and shows the progress.

    Raises:
        BenchError: a measurement failed; the finished ones are stored.
    """
    results: dict[Measurement, list[Episode]] = {}
    failures: dict[str, Failure] = {}
    with open_bars() as (_, show):
        show(TrainingStarted(tuple(each.plan for each in measurements), jobs))
        for index, outcome in Workers(jobs).run([PendingMeasurement(each) for each in measurements], show):
            if isinstance(outcome, Failure):
                failures[measurements[index].title] = outcome
                show(JobFailed(measurements[index].title, outcome.cause))
            else:
                results[measurements[index]] = outcome
    if failures:
        hint = "Finished measurements are stored; repeat the command."
        raise jobs_failed(failures, len(measurements), hint)
    return {each: results[each] for each in measurements}


def measure_all(
    budgets: Mapping[Task, str],
    *,
    agent: str,
    runs: Sequence[int],
    out: Path,
    jobs: int,
    floors_only: bool = False,
) -> dict[str, Any]:
    """Measures every task that a references file does not have.

    If ``out`` exists, a floor or ceiling in it is not measured again. Finished measurements are stored beside
    ``out``, so that an interrupted call can be repeated.

    Args:
        budgets: the training budget of the reference runs, by task.
        agent: the reference agent whose mean return is the ceiling.
        runs: the training seeds of the reference runs.
        out: the path of the references file; its stem is the version.
        jobs: number of worker processes.
        floors_only: leaves the ceilings out.

    Returns:
        The references file's content.

    Raises:
        BenchError: ``out`` is not a references file or has another definition of a task, or a measurement
            failed.
    """
    found, folder = existing_tasks(out, budgets), out.parent / PROGRESS / out.stem
    floors = {task: floor_measurements(task, folder) for task in budgets if task.id not in found}
    ceilings = {
        task: ceiling_measurements(task, budget, runs, agent, folder)
        for task, budget in budgets.items()
        if not floors_only and "ceiling" not in found.get(task.id, {})
    }
    measurements = [each for agents in floors.values() for each in agents.values()]
    measurements += [each for reference_runs in ceilings.values() for each in reference_runs]
    results = measure(measurements, jobs)
    found = existing_tasks(out, budgets)  # another process may have added tasks since
    for task in floors:
        found[task.id] = {"floor": floor_of(task, results)}
    for task, reference_runs in ceilings.items():
        found[task.id] = references_of(found[task.id]["floor"], reference_runs, results)
    return {"format": FORMAT, "version": out.stem, "tasks": found}


def changed_floors(tasks: Iterable[Task], path: Path, jobs: int) -> list[str]:
    """Measures floors again from their seeds and compares them with those of a references file.

    Args:
        tasks: the tasks.
        path: the references file.
        jobs: number of worker processes.

    Returns:
        The ids of the tasks whose mean returns differ by more than rounding errors.
    """
    chosen, found = list(tasks), existing_tasks(path, tasks)
    if missing := [task.id for task in chosen if task.id not in found]:
        raise BenchError("no-reference", f"The file has no floor of {missing[0]}.", str(path))
    results = measure([each for task in chosen for each in floor_measurements(task).values()], jobs)
    return [
        task.id
        for task in chosen
        for again in [floor_of(task, results)["agents"]]
        if any(
            not math.isclose(again[agent]["mean"], stated["mean"], rel_tol=ROUNDING)
            for agent, stated in found[task.id]["floor"]["agents"].items()
        )
    ]


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
            if chosen.setdefault(task, budget(budget_name).name) != budget_name:
                message = f"{task.id} is in two groups with the budgets {chosen[task]} and {budget_name}."
                raise BenchError("bad-budget", message, "--budget", "Use the same budget for these groups.")
    return chosen


def parser() -> argparse.ArgumentParser:
    """The command's options."""
    command = argparse.ArgumentParser(
        prog="gym-extensions maintain references",
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
    target = command.add_mutually_exclusive_group(required=True)
    target.add_argument(
        "--out",
        type=Path,
        help="the file; its stem is the version's name; tasks of an existing file stay as they are",
    )
    target.add_argument(
        "--check", type=Path, metavar="FILE", help="measure the floors in this file again and compare them"
    )
    command.add_argument("--floors-only", action="store_true", help="measure floors and leave ceilings out")
    command.add_argument("--jobs", type=int, default=1, help="worker processes (default: 1)")
    return command


@reports_mistakes
def main(argv: list[str] | None = None) -> int:
    """Measures and writes the references file, or checks its floors; returns the exit status."""
    options = parser().parse_args(argv)
    runs, budgets = parse_runs(options.runs), task_budgets(options.groups, options.budget)
    for run in runs:
        if run < FIRST_REFERENCE_RUN:
            hint = f"Use numbers from {FIRST_REFERENCE_RUN}; smaller ones are reserved for submissions."
            raise BenchError("bad-run", f"Run {run} is out of range.", "--runs", hint)
    require_positive(options.jobs, "--jobs")
    require_published_engine()
    if options.check:
        changed = changed_floors(budgets, options.check, options.jobs)
        print(f"{len(budgets) - len(changed)} of {len(budgets)} floors are the same.")
        for task_id in changed:
            print(f"  {task_id} differs")
        return 1 if changed else 0
    if options.out.is_dir():
        hint = "Name a file, such as references.json."
        raise BenchError("bad-out", "It is a folder.", str(options.out), hint)
    prepare(options.out.parent)
    content = measure_all(
        budgets,
        agent=options.agent,
        runs=runs,
        out=options.out,
        jobs=options.jobs,
        floors_only=options.floors_only,
    )
    write_text(options.out, json.dumps(content, indent=1, ensure_ascii=False) + "\n")
    print(f"The references are in {options.out}.")
    return 0
