"""Every published task: a name, a base body, what differs from it, a version."""

from __future__ import annotations

from gym_extensions.catalog import navigation_tasks as navigation
from gym_extensions.catalog.mujoco_tasks import RUNNING_BODIES, body_tasks
from gym_extensions.catalog.task import NAMESPACE, Task
from gym_extensions.errors import BenchError, did_you_mean

__all__ = ["NAMESPACE", "RUNNING_BODIES", "TASKS", "Task", "task"]

NAVIGATION = [Task(name, navigation.BASE, (course,)) for name, course in navigation.course_rows()]

TASKS: dict[str, Task] = {row.id: row for row in (*body_tasks(), *NAVIGATION)}
"""Every published task by its id."""


def task(name: str) -> Task:
    """The published task of that id, or of its bare name (``HopperGravityHalf``).

    Raises:
        BenchError: there is no such task; the hint names the closest.
    """
    by_name = {known.name: known for known in TASKS.values()}
    found = TASKS.get(name) or by_name.get(name)
    if found is None:
        choices = TASKS if "/" in name else by_name
        raise BenchError("unknown-task", f"There is no task {name!r}.", hint=did_you_mean(name, choices))
    return found
