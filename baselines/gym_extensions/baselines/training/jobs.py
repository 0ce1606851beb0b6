"""The pieces a protocol falls into: each can be run alone, in a process of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from gym_extensions.catalog.budgets import Budget
from gym_extensions.catalog.groups import TaskGroup, group
from gym_extensions.catalog.task import Task


@dataclass(frozen=True)
class Stage:
    """One step of a unit: what is trained (nothing in stage 0), how long, and what is evaluated then."""

    number: int
    trained: tuple[Task, ...]
    steps: int
    evaluated: tuple[Task, ...]


@dataclass(frozen=True)
class Unit:
    """One learner's life: a run of a group's protocol; in the single protocol, of one ``task`` of it."""

    group: str
    protocol: str
    run: int
    task: int | None = None

    @property
    def name(self) -> str:
        """A short name, also its folder's: ``sequential-run0``, ``single-run0-task3``."""
        ending = "" if self.task is None else f"-task{self.task}"
        return f"{self.protocol}-run{self.run}{ending}"

    @property
    def title(self) -> str:
        """Its name with the group's."""
        return f"{self.group} {self.name}"

    @property
    def of(self) -> TaskGroup:
        """The group's row."""
        return group(self.group)

    def stages(self, budget: Budget) -> list[Stage]:
        """What happens, in order."""
        tasks = self.of.tasks
        steps = budget.steps_for(self.group)
        if self.protocol == "sequential":
            trained = [(), *((task,) for task in tasks)]
            return [Stage(k, which, steps if which else 0, tasks) for k, which in enumerate(trained)]
        if self.protocol == "joint":
            return [Stage(1, tasks, steps * len(tasks), tasks)]
        if self.task is None:
            raise ValueError("a unit of the single protocol names its task")
        one = (tasks[self.task],)
        return [Stage(1, one, steps, one)]

    def cells(self, budget: Budget) -> int:
        """Cells that are evaluated in all its stages."""
        return sum(len(stage.evaluated) for stage in self.stages(budget))


def units(group_name: str, protocol: str, runs: Sequence[int]) -> list[Unit]:
    """The units of one log, in order."""
    name = group(group_name).name
    if protocol != "single":
        return [Unit(name, protocol, run) for run in runs]
    return [Unit(name, protocol, run, task) for run in runs for task in range(len(group(name).tasks))]
