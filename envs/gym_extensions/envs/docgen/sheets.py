"""The file of sheets: what pages show of every task without a simulator."""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.navigation_tasks import MAPS
from gym_extensions.catalog.registry import TASKS
from gym_extensions.catalog.task import Task
from gym_extensions.envs.docgen.descriptions import differences
from gym_extensions.envs.docgen.skeleton import skeleton
from gym_extensions.envs.docgen.tables import action_fields, indexed, observation_fields
from gym_extensions.envs.fields import Field


def sheets() -> str:
    """Returns the text of ``sheets.json``: a row per task, and the tables, skeletons and maps they share."""
    tables, skeletons = _Shared(), _Shared()
    tasks = {}
    for row in TASKS.values():
        facts: dict[str, Any] = {
            "differences": differences(row),
            "actions": tables.index(_table(action_fields(row))),
            "observations": tables.index(_table(observation_fields(row))),
        }
        if row.body.family == "navigation":
            facts |= _course(row)
        else:
            facts["skeleton"] = skeletons.index(skeleton(row))
        tasks[row.id] = facts
    maps = [_map(number) for number in MAPS]
    parts = {"maps": maps, "skeletons": skeletons.values, "tables": tables.values}
    lines = [f'"{name}": [\n{_lines(rows)}\n]' for name, rows in parts.items()]
    rows = ",\n".join(f"{json.dumps(key)}: {_compact(value)}" for key, value in tasks.items())
    return "{\n" + ",\n".join([*lines, f'"tasks": {{\n{rows}\n}}']) + "\n}\n"


class _Shared:
    """Different values in the order of their first use."""

    def __init__(self) -> None:
        self.values: list[Any] = []

    def index(self, value: Any) -> int:
        if value not in self.values:
            self.values.append(value)
        return self.values.index(value)


def _table(fields: Iterable[Field]) -> list[tuple[str, str, str, str]]:
    return [(index, field.meaning, field.unit, field.range) for index, field in indexed(fields)]


def _compact(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False, separators=(",", ":"))


def _lines(values: Iterable[Any]) -> str:
    return ",\n".join(map(_compact, values))


def _course(task: Task) -> dict[str, Any]:
    from gym_extensions.envs.navigation.env import course
    from gym_extensions.envs.navigation.grid import HEIGHT, arena

    row = course(task)
    x, y = arena(row.map, row.goal).goal
    return {"map": row.map, "goal": [x, HEIGHT - y]}


def _map(number: int) -> list[list[int]]:
    from gym_extensions.envs.navigation.grid import CELL, load

    return [[int(value * CELL) for value in row] for row in rectangles(load(number).cells[::-1])]


def rectangles(cells: NDArray[np.bool_]) -> list[tuple[int, int, int, int]]:
    """Returns rectangles (x, y, width, height) that cover the true cells, row 0 first, each cell once."""
    left, found = cells.copy(), []
    for y, x in zip(*np.nonzero(cells), strict=True):
        if not left[y, x]:
            continue
        width = int(np.argmin(np.append(left[y, x:], False)))
        below = np.append(left[y:, x : x + width].all(axis=1), False)
        height = int(np.argmin(below))
        left[y : y + height, x : x + width] = False
        found.append((int(x), int(y), width, height))
    return found
