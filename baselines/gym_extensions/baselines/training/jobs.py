"""The independent jobs of a protocol. Each trains one agent and can run in its own process."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from gym_extensions.baselines.context import Observes
from gym_extensions.baselines.training.events import JobPlan, StagePlan
from gym_extensions.catalog.budgets import Budget, budget
from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.catalog.protocol import EVALUATION_EPISODES
from gym_extensions.catalog.task import Task
from gym_extensions.rollouts.manifest import Steps


@dataclass(frozen=True)
class Settings:
    """How jobs run: the agent's and the budget's name, ``num_envs`` if it is not the budget's, and what the
    agent asked to observe.

    ``steps`` is ``recorded`` if the training loop counts the training steps, else ``claimed``.
    ``hyperparameters`` and ``packages`` are those of the agent's card.
    """

    agent: str
    budget: str
    num_envs: int | None = None
    observes: Observes = field(default_factory=Observes)
    steps: Steps = "recorded"
    hyperparameters: Mapping[str, object] = field(default_factory=dict, hash=False)
    packages: tuple[str, ...] = ()

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
    def run_key(self) -> tuple[str, str, int]:
        """The group's name, the protocol and the run: what the jobs of one run have in common."""
        return self.group.name, self.protocol, self.run

    @property
    def title(self) -> str:
        """The group's and the job's name."""
        return f"{self.group.name} {self.name}"

    @property
    def run_title(self) -> str:
        """The group's name, the protocol and the run, as text."""
        return f"{self.group.name} {self.protocol}-run{self.run}"

    def stages(self, budget: Budget) -> list[Stage]:
        """The stages in order."""
        tasks = self.group.tasks
        steps = budget.steps_for(self.group.name)
        if self.protocol == "sequential":
            trained = [(), *((task,) for task in tasks)]
            return [Stage(k, which, steps if which else 0, tasks) for k, which in enumerate(trained)]
        if self.protocol == "joint":
            return [Stage(1, tasks, steps * len(tasks), tasks)]
        if self.task is None:
            raise ValueError("a job of the single protocol needs a task")
        alone = (tasks[self.task],)
        return [Stage(1, alone, steps, alone)]

    def plan(self, budget: Budget, interim: Interim | None = None) -> JobPlan:
        """The work of every stage."""
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
