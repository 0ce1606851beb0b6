"""The independent jobs of a protocol, their seeds, and what their results depend on.

Each job trains one agent and can run in its own process.
"""

from __future__ import annotations

import copy
import hashlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import gymnasium as gym
import numpy as np

from gym_extensions.baselines.training.events import JobPlan, StagePlan
from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.catalog.protocol import EVALUATION_EPISODES, Budget, budget
from gym_extensions.catalog.tasks import Task
from gym_extensions.submissions.manifest import Observes, Steps
from gym_extensions.versions import version

PACKAGES = ("gym_extensions", "gymnasium", "mujoco", "numpy")
"""The packages on which the results of every job depend."""


def training_seed(run: int, *purpose: str) -> int:
    """A seed in [0, 2³²) for one purpose in one run: ``SeedSequence([run, …])`` with the purpose's sha256."""
    digest = hashlib.sha256("/".join(purpose).encode()).digest()
    words = [int.from_bytes(digest[start : start + 4], "little") for start in range(0, 16, 4)]
    return int(np.random.SeedSequence([run, *words]).generate_state(1)[0])


def spawn_seeds(seed: int, num_envs: int) -> list[int]:
    """Spawns one seed per environment from one seed. Neighboring seeds share none of them."""
    return [int(child.generate_state(1)[0]) for child in np.random.SeedSequence(seed).spawn(num_envs)]


def seeded_copy(space: gym.Space[Any], seed: int) -> gym.Space[Any]:
    """A copy of a space that samples from a seed of its own."""
    own = copy.deepcopy(space)
    own.seed(seed % 2**31)
    return own


def job_versions(packages: Iterable[str] = ()) -> dict[str, str]:
    """The versions of the packages that every job uses, and of those that its agent uses besides them."""
    return {name: version(name.replace("_", "-")) for name in (*PACKAGES, *packages)}


@dataclass(frozen=True)
class Settings:
    """How jobs run."""

    agent: str  # its name, as that of the budget
    budget: str
    num_envs: int | None = None  # None: the budget's
    observes: Observes = field(default_factory=Observes)
    steps: Steps = "recorded"  # "claimed" if the training loop does not count the training steps
    hyperparameters: Mapping[str, object] = field(default_factory=dict, hash=False)  # of the agent's card
    packages: tuple[str, ...] = ()  # the same

    def num_envs_for(self, num_tasks: int) -> int:
        """Training environments: a multiple of the number of tasks, so that each task has equally many."""
        requested = self.num_envs or budget(self.budget).num_envs
        return -(-requested // num_tasks) * num_tasks


@dataclass(frozen=True)
class Interim:
    """Evaluation during training: after every ``every`` steps of a stage, with ``episodes`` episodes."""

    every: int
    episodes: int

    def count(self, steps: int, batch_steps: int) -> int:
        """Evaluations in a stage. Each is at the end of a batch, and the end of the stage is not one."""
        batches = {-(-step // batch_steps) for step in range(self.every, steps, self.every)}
        return sum(batch * batch_steps < steps for batch in batches)


@dataclass(frozen=True)
class Stage:
    """One stage of a job: train on ``trained`` for ``steps`` transitions, then evaluate on ``evaluated``.

    Stage 0 trains nothing.
    """

    number: int
    trained: tuple[Task, ...]
    steps: int
    evaluated: tuple[Task, ...]


@dataclass(frozen=True)
class TrainingJob:
    """One agent in one run of a protocol; in the single protocol, on the task at index ``task``."""

    group: TaskGroup
    protocol: str
    run: int
    task: int | None = None

    @property
    def name(self) -> str:
        """A short name and the name of the job's folder: ``sequential-run0``, ``single-run0-task3``."""
        ending = "" if self.task is None else f"-task{self.task}"
        return f"{self.protocol}-run{self.run}{ending}"

    @property
    def task_name(self) -> str | None:
        """The name of the trained task in the single protocol, else None."""
        return None if self.task is None else self.group.tasks[self.task].name

    @property
    def title(self) -> str:
        return f"{self.group.name} {self.name}"

    @property
    def run_title(self) -> str:
        """The group's name, the protocol and the run: what the jobs of one run have in common."""
        return f"{self.group.name} {self.protocol}-run{self.run}"

    def stages(self, budget: Budget) -> list[Stage]:
        tasks, steps = self.group.tasks, budget.steps_for(self.group.name)
        if self.protocol == "sequential":
            trained = [(), *((task,) for task in tasks)]
            return [Stage(k, which, steps if which else 0, tasks) for k, which in enumerate(trained)]
        if self.protocol == "joint":
            return [Stage(1, tasks, steps * len(tasks), tasks)]
        if self.protocol == "cumulative":
            return [Stage(1, tasks[-1:], steps * len(tasks), tasks)]
        assert self.task is not None, "a job of the single protocol needs a task"
        alone = (tasks[self.task],)
        return [Stage(1, alone, steps, alone)]

    def plan(self, budget: Budget, interim: Interim | None = None) -> JobPlan:
        plans = []
        for stage in self.stages(budget):
            during = interim.episodes * interim.count(stage.steps, budget.batch_steps) if interim else 0
            episodes = (EVALUATION_EPISODES + during) * len(stage.evaluated)
            plans.append(StagePlan(stage.number, stage.steps, episodes))
        return JobPlan(self.title, tuple(plans))


def jobs_of(group: TaskGroup, protocol: str, runs: Sequence[int]) -> list[TrainingJob]:
    """The jobs of one log, in order."""
    if protocol != "single":
        return [TrainingJob(group, protocol, run) for run in runs]
    return [TrainingJob(group, protocol, run, task) for run in runs for task in range(len(group.tasks))]
