"""Groups that users define themselves, as a Python object or a TOML file.

A custom group is trained, recorded and scored like a published one. It never takes the name of one.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from gym_extensions.catalog.custom import customize
from gym_extensions.catalog.definitions import check_keys, make_variation
from gym_extensions.catalog.groups import GROUPS, TaskGroup
from gym_extensions.catalog.groups import group as published_group
from gym_extensions.catalog.registry import task as published_task
from gym_extensions.catalog.task import Task
from gym_extensions.errors import BenchError

GROUP_KEYS = ("name", "version", "tasks")
TASK_KEYS = ("task", "variations", "max_steps")


def load_group(path: str | Path) -> TaskGroup:
    """Reads a custom group from a TOML file.

    The file holds ``name``, an optional ``version``, and a list of tasks in training order. Each task names a
    published task and may add variations and a time limit::

        name = "hopper-light"

        [[tasks]]
        task = "Hopper"

        [[tasks]]
        task = "Hopper"
        variations = [{kind = "Gravity", factor = 0.3}]
        max_steps = 500

    Args:
        path: the TOML file.

    Returns:
        The group. Its tasks are published tasks wherever they equal one.

    Raises:
        BenchError: the file cannot be read or is not TOML; a key, task, kind of variation or parameter is
            unknown; a value is invalid; a task occurs twice; or the name belongs to a published group.
    """
    where = str(path)
    try:
        table = tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise BenchError("unreadable-group", f"{error.strerror or error}.", where) from error
    except ValueError as error:
        raise BenchError("malformed-group", f"The file is not TOML: {error}.", where) from error
    check_keys(table, GROUP_KEYS, ("name", "tasks"), where)
    rows = table["tasks"]
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
        raise BenchError(
            "malformed-group", "tasks is not a list of tables.", where, "Write [[tasks]] per task."
        )
    tasks = tuple(_task(row, f"{where}, task {number}") for number, row in enumerate(rows, 1))
    try:
        return resolve_group(TaskGroup(table["name"], tasks, table.get("version", 0)))
    except BenchError as error:
        raise BenchError(error.code, error.message, where, error.hint) from error


def resolve_group(group: str | Path | TaskGroup) -> TaskGroup:
    """The group that an argument or a command line names.

    Args:
        group: the name of a published group, a TaskGroup, or a path to a TOML file (it ends in ``.toml``).

    Raises:
        BenchError: there is no such group, the file is invalid, or a custom group has the name of a
            published one.
    """
    if isinstance(group, TaskGroup):
        if group.name in GROUPS and not group.published:
            message = f"{group.name!r} is the name of a published group with other tasks."
            raise BenchError("name-taken", message, "name", "Choose another name.")
        return group
    return load_group(group) if str(group).endswith(".toml") else published_group(str(group))


def with_custom(groups: Iterable[str | Path | TaskGroup]) -> dict[str, TaskGroup]:
    """The published groups and these custom groups, by name.

    Raises:
        BenchError: a group is invalid (see :func:`resolve_group`), or two have the same name.
    """
    known = dict(GROUPS)
    for group in map(resolve_group, groups):
        if known.setdefault(group.name, group) != group:
            message = f"Two groups have the name {group.name!r}."
            raise BenchError("name-taken", message, "--groups", "Rename one of them.")
    return known


def _task(row: Mapping[str, Any], where: str) -> Task:
    check_keys(row, TASK_KEYS, ("task",), where)
    variations = row.get("variations", [])
    if not isinstance(variations, list):
        hint = 'Write variations = [{kind = "Gravity", factor = 0.5}].'
        raise BenchError("malformed-group", "variations is not a list.", where, hint)
    try:
        base = published_task(str(row["task"]))
        return customize(
            base, [make_variation(each, where) for each in variations], max_steps=row.get("max_steps")
        )
    except BenchError as error:
        raise BenchError(error.code, error.message, error.where or where, error.hint) from error
