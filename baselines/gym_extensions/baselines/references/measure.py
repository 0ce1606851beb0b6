"""Measures one agent on one task for the references."""

from __future__ import annotations

import json
import time
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from gym_extensions.atomic import write_text
from gym_extensions.baselines import algorithms
from gym_extensions.baselines.agent import Agent, VectorEnv
from gym_extensions.baselines.agent_checks import card_of
from gym_extensions.baselines.training.evaluation import evaluate
from gym_extensions.baselines.training.events import BatchTrained, Listener, TaskEvaluated
from gym_extensions.baselines.training.jobs import Settings
from gym_extensions.baselines.training.recorder import Batch, Recorder
from gym_extensions.baselines.training.seeding import training_seed
from gym_extensions.baselines.training.versions import job_versions
from gym_extensions.catalog.budgets import budget
from gym_extensions.catalog.protocol import evaluation_seed
from gym_extensions.catalog.task import Task
from gym_extensions.envs import make_vec
from gym_extensions.envs.fingerprint import fingerprint_of
from gym_extensions.rollouts.episodes import Episode

ARRIVAL_REWARD = 10.0
REFERENCE = "reference"
"""Replaces a group's id in the derivation of seeds."""
NUM_ENVS = 100
ORACLE = "oracle"
"""Plans on the map of a navigation task and takes the fewest steps: the ceiling of these tasks."""
SEED_NAMES = {"trpo-2017": "trpo"}
"""Agents that were renamed after references were measured. Their seeds are derived from the earlier name."""


@dataclass(frozen=True)
class Measurement:
    """An agent on a task: the run, the number of episodes and the training budget (untrained if empty)."""

    task: Task
    agent: str
    run: int
    episodes: int
    budget: str = ""

    @property
    def title(self) -> str:
        """A readable name."""
        ending = f" run {self.run}" if self.budget else ""
        return f"{self.task.id} {self.agent}{ending}"

    @property
    def steps(self) -> int:
        """Training steps."""
        return budget(self.budget).batches * budget(self.budget).batch_steps if self.budget else 0

    @property
    def agent_seed(self) -> int:
        """The seed of the agent."""
        return training_seed(self.run, REFERENCE, self.task.id, SEED_NAMES.get(self.agent, self.agent))

    def path(self, folder: Path) -> Path:
        """The file of its result."""
        task = self.task.id.rpartition("/")[2]
        return folder / f"{task}-{self.agent}-{self.budget or 'untrained'}-{self.run}-{self.episodes}.json"


@dataclass(frozen=True)
class PendingMeasurement:
    """A measurement that a worker process can run.

    An existing result is not measured again, unless its agent's settings or the versions of packages differ.
    """

    measurement: Measurement
    folder: Path

    def run(self, listen: Listener) -> list[Episode]:
        """The measurement's episodes, stored in its file."""
        path = self.measurement.path(self.folder)
        task = self.measurement.task
        settings: dict[str, Any] = {"title": self.measurement.title, "fingerprint": fingerprint_of(task)}
        settings |= _provenance(self.measurement)
        if path.exists():
            stored: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
            if stored["settings"] == json.loads(json.dumps(settings)):
                return [Episode(**row) for row in stored["episodes"]]
        episodes = measure(self.measurement, listen)
        content = {"settings": settings, "episodes": [asdict(row) for row in episodes]}
        write_text(path, json.dumps(content) + "\n")
        return episodes


def _provenance(measurement: Measurement) -> dict[str, Any]:
    """What a result depends on besides its task: the agent's settings, and the versions of packages."""
    if measurement.agent == ORACLE:
        return {"versions": job_versions()}
    env = make_vec(measurement.task, 1)
    make = algorithms.factory(measurement.agent)
    agent = make(env.single_observation_space, env.single_action_space, measurement.agent_seed)
    env.close()
    card = card_of(agent, measurement.agent)
    return {"versions": job_versions(card.packages), "hyperparameters": dict(card.hyperparameters)}


def measure(measurement: Measurement, listen: Listener) -> list[Episode]:
    """Trains the agent if it has a budget, and evaluates it with the prescribed reference seeds."""
    if measurement.agent == ORACLE:
        return _oracle_episodes(measurement)
    env = make_vec(measurement.task, min(NUM_ENVS, measurement.episodes))
    make = algorithms.factory(measurement.agent)
    agent = make(env.single_observation_space, env.single_action_space, measurement.agent_seed)
    if measurement.budget:
        _train(agent, measurement, listen)
    start = time.perf_counter()
    rows = _evaluate(agent, env, measurement)
    mean_return, seconds = sum(row.return_ for row in rows) / len(rows), time.perf_counter() - start
    steps = measurement.steps
    listen(
        TaskEvaluated(
            measurement.title, 1, steps, steps, measurement.task.id, len(rows), mean_return, seconds
        )
    )
    env.close()
    return rows


def _seeds(measurement: Measurement, episodes: Iterable[int]) -> list[int]:
    return [evaluation_seed(REFERENCE, measurement.task.id, episode) for episode in episodes]


def _oracle_episodes(measurement: Measurement) -> list[Episode]:
    from gym_extensions.envs.navigation.oracle import oracle_returns

    task = measurement.task
    seeds = _seeds(measurement, range(measurement.episodes))
    rows = []
    for episode, (seed, return_) in enumerate(zip(seeds, oracle_returns(task, seeds), strict=True)):
        length = round(ARRIVAL_REWARD - return_)  # no collisions: −1 per step, and the reward of arrival
        result = (seed, length, float(return_), True, True, fingerprint_of(task))
        rows.append(Episode(measurement.run, 1, task.id, episode, *result))
    return rows


def _train(agent: Agent, measurement: Measurement, listen: Listener) -> None:
    plan, steps = budget(measurement.budget), measurement.steps
    env = make_vec(measurement.task, Settings(measurement.agent, plan.name).num_envs_for(1))

    def report(batch: Batch) -> None:
        speed = batch.steps / max(batch.seconds, 1e-9)
        measured = (batch.step, batch.step, batch.mean_return, speed, batch.seconds)
        listen(BatchTrained(measurement.title, 1, *measured))

    recorder = Recorder(
        env,
        [measurement.task.id],
        steps=steps,
        batch_steps=plan.batch_steps,
        seed=training_seed(measurement.run, REFERENCE, measurement.task.id, "training"),
        report=report,
    )
    agent.learn(recorder, steps)
    env.close()


def _evaluate(agent: Agent, env: VectorEnv, measurement: Measurement) -> list[Episode]:
    task_id, rows = measurement.task.id, list[Episode]()
    fingerprint = fingerprint_of(measurement.task)
    for first in range(0, measurement.episodes, env.num_envs):
        numbers = range(first, first + env.num_envs)
        seeds = _seeds(measurement, numbers)
        for episode, seed, rollout in zip(numbers, seeds, evaluate(agent, env, seeds), strict=True):
            result = (seed, rollout.length, rollout.return_, rollout.terminated, rollout.success, fingerprint)
            rows.append(Episode(measurement.run, 1, task_id, episode, *result))
    return rows[: measurement.episodes]
