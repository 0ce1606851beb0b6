"""Measures agents on tasks with prescribed seeds: those of the floor, the planner, and agents trained alone.

Finished measurements are stored, so that an interrupted command can be repeated.
"""

from __future__ import annotations

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
from gym_extensions.catalog.protocol import FIRST_REFERENCE_RUN, budget, evaluation_seed
from gym_extensions.catalog.tasks import Task
from gym_extensions.envs import make_vec
from gym_extensions.envs.fingerprint import fingerprint_of
from gym_extensions.experts.references import FloorAgent
from gym_extensions.files import write_text
from gym_extensions.rollouts.tables import Episode

FLOOR_AGENTS = ("random", "zero")
PLANNER = "planner"
"""Plans on the map of a navigation task and takes the fewest steps: the expert of these tasks."""
FLOOR_EPISODES, TRAINED_EPISODES = 1000, 100
NUM_ENVS = 100
ARRIVAL_REWARD = 10.0
REFERENCE = "reference"
"""Replaces a group's id in the derivation of seeds."""


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
        return training_seed(self.run, REFERENCE, self.task.id, self.agent)

    @property
    def plan(self) -> JobPlan:
        """The work."""
        return JobPlan(self.title, (StagePlan(1, self.steps, self.episodes),))

    def seeds(self, episodes: Iterable[int]) -> list[int]:
        """The prescribed seeds of episodes."""
        return [evaluation_seed(REFERENCE, self.task.id, episode) for episode in episodes]

    def run_episodes(self, listen: Listener) -> list[Episode]:
        """Trains the agent if it has a budget, and evaluates it with the prescribed seeds."""
        if self.agent == PLANNER:
            return self._planned_episodes()
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
        mean_return = sum(returns_of(episodes)) / len(episodes)
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
        if self.agent == PLANNER:
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

    def _planned_episodes(self) -> list[Episode]:
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


def floor_measurements(task: Task, folder: Path | None = None, episodes: int = 0) -> list[Measurement]:
    """The measurements of a task's floor; of fewer episodes than 1,000 if ``episodes`` says so."""
    count = min(episodes or FLOOR_EPISODES, FLOOR_EPISODES)
    return [Measurement(task, agent, FIRST_REFERENCE_RUN, count, folder=folder) for agent in FLOOR_AGENTS]


def planner_measurement(task: Task, folder: Path | None = None, episodes: int = 0) -> Measurement:
    """The measurement of the expert of a navigation task."""
    count = min(episodes or FLOOR_EPISODES, FLOOR_EPISODES)
    return Measurement(task, PLANNER, FIRST_REFERENCE_RUN, count, folder=folder)


def trained_measurements(
    task: Task, agent: str, budget: str, runs: Sequence[int], folder: Path | None = None
) -> list[Measurement]:
    """The measurements of a custom task's expert: training runs, or the planner in navigation."""
    if task.base == "Navigation":
        return [planner_measurement(task, folder)]
    return [Measurement(task, agent, run, TRAINED_EPISODES, budget, folder) for run in runs]


def summary(returns: Sequence[float]) -> FloorAgent:
    """Mean, population standard deviation and standard error of the mean of episode returns."""
    mean = math.fsum(returns) / len(returns)
    std = math.sqrt(math.fsum((value - mean) ** 2 for value in returns) / len(returns))
    return FloorAgent(mean, std, std / math.sqrt(len(returns)))


def returns_of(episodes: Sequence[Episode]) -> list[float]:
    """The returns of episodes."""
    return [episode.return_ for episode in episodes]


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
