"""Every published task, by its id."""

from __future__ import annotations

from gym_extensions.catalog.mujoco_tasks import mujoco_tasks
from gym_extensions.catalog.navigation_tasks import navigation_tasks
from gym_extensions.catalog.task import NAMESPACE, Task
from gym_extensions.errors import BenchError, did_you_mean

__all__ = ["NAMESPACE", "TASKS", "VERSIONS", "Task", "task"]

TASKS: dict[str, Task] = {row.id: row for row in (*mujoco_tasks(), *navigation_tasks())}
"""Every published task by its id."""

VERSIONS = {0: "first published version"}
"""What changed with each version number of a task."""


def task(name: str) -> Task:
    """Returns the published task with that id or bare name (``HopperGravityHalf``).

    Raises:
        BenchError: no task has that name; the hint names the closest.
    """
    by_name = {row.name: row for row in TASKS.values()}
    row = TASKS.get(name) or by_name.get(name)
    if row is None:
        choices = TASKS if "/" in name else by_name
        raise BenchError("unknown-task", f"There is no task {name!r}.", hint=did_you_mean(name, choices))
    return row
