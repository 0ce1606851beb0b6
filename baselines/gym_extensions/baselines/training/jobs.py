"""What a command trains: its checked arguments, the independent jobs of its protocols, and their stages.

Each job trains one agent and can run in its own process.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from numbers import Integral
from pathlib import Path
from typing import Any

from gym_extensions.baselines.agent import EXCESS
from gym_extensions.baselines.agent_spec import AgentSpec
from gym_extensions.catalog.groups import Groups, TaskGroup, groups_named, with_custom
from gym_extensions.catalog.protocol import (
    CURVE_POINTS,
    IN_ORDER,
    PROTOCOLS,
    Budget,
    budget as budget_named,
    task_order,
)
from gym_extensions.catalog.tasks import Task
from gym_extensions.envs import foreign, make_vec
from gym_extensions.errors import BenchError, require_known, whole_number
from gym_extensions.submissions.characters import first_invisible
from gym_extensions.submissions.layout import MAX_RUNS
from gym_extensions.submissions.run import LONGEST


@dataclass(frozen=True)
class Parallel:
    """What runs at the same time in training. Raises ``BenchError`` for a number that is not a whole number.

    Args:
        jobs: number of worker processes with one thread each; the factory must pickle. 0 trains in this
            process with its number of threads; agents of Stable-Baselines3 set that of torch to 1.
        num_envs: number of training environments of a job, on which results depend; the budget's if None.
        num_threads: threads that step the training environments of one job, for one long job on several
            processors. Results do not depend on it.

    Example:
        >>> Parallel(jobs=2)
        Parallel(jobs=2, num_envs=None, num_threads=1)
    """

    jobs: int = 0
    num_envs: int | None = None
    num_threads: int = 1

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if name != "num_envs" or value is not None:
                dashed, least = name.replace("_", "-"), 0 if name == "jobs" else 1
                number = whole_number(name, value, f"bad-{dashed}", f"--{dashed}", least)
                object.__setattr__(self, name, number)


@dataclass(frozen=True)
class Origin:
    """Who trains runs, and from what their seeds follow. Raises ``BenchError`` for anything but such texts.

    Args:
        by: who trains them, at most 200 characters: for runs that are donated to a submission of others.
        seeds: a text from which, with group and run, all seeds of training follow. Without one they follow
            from the run's number. Runs that the project trains have one that nobody knew before.
    """

    by: str = ""
    seeds: str = ""

    def __post_init__(self) -> None:
        is_text = isinstance(self.seeds, str) and isinstance(self.by, str) and len(self.by) <= LONGEST
        if not is_text or first_invisible(self.by + self.seeds):
            hint = f"Give texts without control characters, for by of at most {LONGEST} characters."
            message = f"by is {self.by!r}, seeds is {self.seeds!r}."
            raise BenchError("bad-origin", message, "Origin", hint)


@dataclass(frozen=True)
class Request:
    """Groups, protocols, a budget and runs, without duplicates."""

    groups: tuple[TaskGroup, ...]
    protocols: tuple[str, ...]
    budget: Budget
    runs: tuple[int, ...]

    def logs(self) -> list[tuple[TaskGroup, str]]:
        """The group and protocol of every log."""
        return [(group, protocol) for group in self.groups for protocol in self.protocols]


def parse_request(
    groups: Groups,
    protocols: str | Iterable[str],
    budget: str,
    runs: int | Iterable[int],
    num_envs: int | None = None,
) -> Request:
    """Checks the arguments of :func:`gym_extensions.baselines.train`.

    Raises ``BenchError`` for an unknown name, an empty list, or a number that is not allowed.
    """
    unique_groups = tuple(dict.fromkeys(parse_groups(groups)))
    unique_protocols = tuple(dict.fromkeys(listed(protocols, str, "protocols", "a name")))
    for protocol in unique_protocols:
        require_known("protocol", protocol, PROTOCOLS)
    chosen = budget_named(str(budget))
    unique_runs = tuple(sorted({int(run) for run in listed(runs, Integral, "runs", "an integer")}))
    for run in unique_runs:
        if not 0 <= run < MAX_RUNS:
            raise BenchError("bad-run", f"Run {run} is out of range.", "--runs", f"Use 0 to {MAX_RUNS - 1}.")
    if num_envs is not None:
        for group in unique_groups:
            steps, longest = chosen.steps_for(group.name), max(task.max_steps for task in group.tasks)
            limit = steps // (longest * CURVE_POINTS) if chosen.on_boards else int(steps * EXCESS)
            if num_envs > limit:
                has = f"the budget {chosen.name!r} has fewer than {CURVE_POINTS} episodes per environment"
                takes = f"a step of all takes more than {EXCESS:.0%} of the budget {chosen.name!r}"
                message = f"With {num_envs} environments, {has if chosen.on_boards else takes}."
                hint = f"Use at most {limit} for {group.name}."
                raise BenchError("bad-num-envs", message, "--num-envs", hint)
    return Request(unique_groups, unique_protocols, chosen, unique_runs)


def parse_groups(groups: Groups) -> list[TaskGroup]:
    """The groups of an argument: names of published groups, ``core``, TOML files, TaskGroup objects.

    Raises ``BenchError`` for an unknown name, an invalid file, or two different groups with one name.
    """
    values = listed(groups, (str, Path, TaskGroup), "groups", "a name, a TOML file, a TaskGroup")
    resolved = [group for value in values for group in groups_named(value)]
    with_custom(resolved)
    return resolved


def listed(value: object, kind: Any, name: str, expected: str) -> list[Any]:
    """A value of a kind as a list, or several of them."""
    items = list(value) if isinstance(value, Iterable) and not isinstance(value, kind) else [value]
    if not items or not all(isinstance(item, kind) for item in items):
        raise BenchError(f"bad-{name}", f"Expected {expected} or several, got {value!r}.", name)
    return items


def require_fit(groups: Iterable[TaskGroup]) -> None:
    """Raises ``BenchError`` if the tasks of a group cannot be made, are broken, or have different spaces."""
    for group in groups:
        try:
            make_vec(list(group.tasks), len(group.tasks)).close()
            if theirs := [task for task in group.tasks if task.is_foreign]:
                foreign.check(theirs)
        except BenchError as error:
            where = group.name if error.code == "different-spaces" else f"{group.name}, {error.where}"
            raise BenchError(error.code, error.message, where, error.hint) from error


@dataclass(frozen=True)
class Settings:
    """How all jobs of a command run."""

    agent: AgentSpec
    budget: Budget
    num_envs: int | None = None  # None: the budget's
    num_threads: int = 1  # threads that step the training environments; results do not depend on it
    evaluate_every: int | None = None  # training steps of a stage between evaluations during training
    evaluate_episodes: int = 5  # episodes per task of these
    seeds: str = ""  # a text from which the seeds of a run follow; without one, they follow from its number
    steps_counted: bool = True  # False if the training loop does not count the training steps

    def num_envs_for(self, num_tasks: int) -> int:
        """Training environments: a multiple of the number of tasks, so that each task has equally many."""
        requested = self.num_envs or self.budget.num_envs
        return -(-requested // num_tasks) * num_tasks


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
        if self.protocol in IN_ORDER:
            order = task_order(self.protocol, self.run, len(tasks))
            trained = [(), *((tasks[index],) for index in order)]
            return [Stage(k, which, steps if which else 0, tasks) for k, which in enumerate(trained)]
        if self.protocol == "joint":
            return [Stage(1, tasks, steps * len(tasks), tasks)]
        if self.protocol == "cumulative":
            return [Stage(1, tasks[-1:], steps * len(tasks), tasks)]
        assert self.task is not None, "a job of the single protocol needs a task"
        alone = (tasks[self.task],)
        return [Stage(1, alone, steps, alone)]


def jobs_of(group: TaskGroup, protocol: str, runs: Sequence[int]) -> list[TrainingJob]:
    """The jobs of one log, in order."""
    if protocol != "single":
        return [TrainingJob(group, protocol, run) for run in runs]
    return [TrainingJob(group, protocol, run, task) for run in runs for task in range(len(group.tasks))]
