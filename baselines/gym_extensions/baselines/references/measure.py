"""One agent measured on one task for the references: trained on it alone, or not at all, then evaluated."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from gym_extensions.atomic import write_text
from gym_extensions.baselines import algorithms
from gym_extensions.baselines.agent import Agent, VectorEnv
from gym_extensions.baselines.training.evaluation import evaluate
from gym_extensions.baselines.training.recorder import Recorder
from gym_extensions.baselines.training.runner import Listener, News, Settings
from gym_extensions.baselines.training.seeding import training_seed
from gym_extensions.catalog.budgets import budget
from gym_extensions.catalog.fingerprints import published
from gym_extensions.catalog.protocol import evaluation_seed
from gym_extensions.catalog.registry import task as task_named
from gym_extensions.envs import make_vec
from gym_extensions.rollouts.episodes import Episode

ARRIVAL = 10.0
REFERENCE = "reference"
"""Stands in place of a group's id where seeds are derived."""
LANES = 100
ORACLE = "oracle"
"""Knows the map of a navigation task and takes the fewest steps; the ceiling of these tasks."""


@dataclass(frozen=True)
class Measurement:
    """An agent on a task: which run, how many episodes, trained for which budget (untrained if empty)."""

    task: str
    agent: str
    run: int
    episodes: int
    budget: str = ""

    @property
    def title(self) -> str:
        """A name in words."""
        return f"{self.task} {self.agent} run {self.run}" if self.budget else f"{self.task} {self.agent}"

    def part(self, folder: Path) -> Path:
        """Where its result is kept."""
        bare = self.task.rpartition("/")[2]
        return folder / f"{bare}-{self.agent}-{self.budget or 'untrained'}-{self.run}-{self.episodes}.json"


@dataclass(frozen=True)
class MeasurementWork:
    """A measurement as a piece of work for a process; a part that is there is not measured again."""

    what: Measurement
    folder: Path

    def run(self, listen: Listener) -> list[Episode]:
        """Its evaluation episodes; kept in its part."""
        path = self.what.part(self.folder)
        settings = asdict(self.what) | {"fingerprint": published(self.what.task)}
        if path.exists():
            kept: dict[str, Any] = json.loads(path.read_text())
            if kept["settings"] == settings:
                return [Episode(**row) for row in kept["episodes"]]
        found = measure(self.what, listen)
        content = {"settings": settings, "episodes": [asdict(row) for row in found]}
        write_text(path, json.dumps(content) + "\n")
        return found


def agent_seed(what: Measurement) -> int:
    """What the agent's generator is seeded with."""
    return training_seed(what.run, REFERENCE, what.task, what.agent)


def measure(what: Measurement, listen: Listener) -> list[Episode]:
    """The measurement's episodes at the prescribed reference seeds."""
    if what.agent == ORACLE:
        return _oracle_episodes(what)
    lanes = make_vec(what.task, min(LANES, what.episodes))
    spaces = (lanes.single_observation_space, lanes.single_action_space)
    agent = algorithms.factory(what.agent)(*spaces, agent_seed(what))
    if what.budget:
        _train(agent, what, listen)
    rows = _episodes(agent, lanes, what)
    mean = sum(row.return_ for row in rows) / len(rows)
    listen(News(what.title, 1, 0, what.task, mean))
    lanes.close()
    return rows


def _oracle_episodes(what: Measurement) -> list[Episode]:
    from gym_extensions.envs.navigation.oracle import oracle_returns

    task = task_named(what.task)
    seeds = [evaluation_seed(REFERENCE, task.id, episode) for episode in range(what.episodes)]
    rows = []
    for episode, (seed, found) in enumerate(zip(seeds, oracle_returns(task, seeds), strict=True)):
        length = round(ARRIVAL - found)  # it never collides: -1 a step, and the reward of arriving
        end = (seed, length, float(found), True, published(task.id))
        rows.append(Episode(what.run, 1, task.id, episode, *end))
    return rows


def _train(agent: Agent, what: Measurement, listen: Listener) -> None:
    plan = budget(what.budget)
    env = make_vec(what.task, Settings(what.agent, what.budget).lanes_for(1))
    steps = plan.batches * plan.batch_steps
    seed = training_seed(what.run, REFERENCE, what.task, "training")
    report = lambda taken: listen(News(what.title, 1, taken))  # noqa: E731
    batch = plan.batch_steps
    recorder = Recorder(env, [what.task], steps=steps, batch_steps=batch, seed=seed, report=report)
    agent.learn(recorder, steps)
    env.close()


def _episodes(agent: Agent, lanes: VectorEnv, what: Measurement) -> list[Episode]:
    pinned, rows = published(task_named(what.task).id), list[Episode]()
    for first in range(0, what.episodes, lanes.num_envs):
        numbers = range(first, first + lanes.num_envs)
        seeds = [evaluation_seed(REFERENCE, what.task, episode) for episode in numbers]
        for episode, seed, found in zip(numbers, seeds, evaluate(agent, lanes, seeds), strict=True):
            end = (seed, found.length, found.return_, found.terminated, pinned)
            rows.append(Episode(what.run, 1, what.task, episode, *end))
    return rows[: what.episodes]
