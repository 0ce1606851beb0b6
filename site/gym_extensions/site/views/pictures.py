"""Pictures of groups: that of the first task which has one."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from gym_extensions.catalog.groups import GROUPS
from gym_extensions.catalog.suites import SUITES

FOLDER = Path(__file__).parent.parent / "pictures"
SUFFIXES = (".png", ".svg", ".webp")


@cache
def pictures() -> dict[str, Path]:
    """The picture files of the package by their names without suffix; empty without the folder."""
    files = sorted(FOLDER.iterdir()) if FOLDER.is_dir() else []
    return {file.stem: file for file in files if file.suffix in SUFFIXES}


def task_picture(task_id: str) -> str:
    """The path of a task's picture on the site; empty without one."""
    name = task_id.rsplit("/", maxsplit=1)[-1].rpartition("-v")[0].lower()
    file = pictures().get(name)
    return f"pictures/{file.name}" if file else ""


def group_picture(group_id: str) -> str:
    """The path of the picture that stands for a group or suite; empty without one."""
    member = next(
        (group for group in GROUPS.values() if group.id == SUITES.get(group_id, (group_id,))[0]), None
    )
    tasks = member.task_ids if member else ()
    return next((path for task in tasks if (path := task_picture(task))), "")
