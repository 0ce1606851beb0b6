"""Pictures of tasks and groups: files of the package, and drawn maps."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from gym_extensions.catalog.groups import GROUPS
from gym_extensions.catalog.pictures import large_picture
from gym_extensions.catalog.registry import TASKS
from gym_extensions.catalog.suites import SUITES
from gym_extensions.catalog.task import Task
from gym_extensions.catalog.variations.maps import Course

FOLDER = Path(__file__).parent.parent / "pictures"


@cache
def pictures() -> dict[str, Path]:
    """The picture files of the package by their names; empty without the folder."""
    return {file.name: file for file in sorted(FOLDER.iterdir())} if FOLDER.is_dir() else {}


def map_picture(task: Task) -> str:
    """The file name of the drawn map with its goal; empty for a task without a map."""
    courses = [variation for variation in task.variations if isinstance(variation, Course)]
    return f"map{courses[0].map}-goal{courses[0].goal}.svg" if courses else ""


def task_picture(task_id: str) -> str:
    """The path of a task's picture on the site; empty without one."""
    task = TASKS.get(task_id)
    if task is None:
        return ""
    name = large_picture(task)
    name = name if name in pictures() else map_picture(task)
    return f"pictures/{name}" if name else ""


def group_picture(group_id: str) -> str:
    """The path of the picture that stands for a group or suite; empty without one."""
    member = next(
        (group for group in GROUPS.values() if group.id == SUITES.get(group_id, (group_id,))[0]), None
    )
    tasks = member.task_ids if member else ()
    return next((path for task in tasks if (path := task_picture(task))), "")
