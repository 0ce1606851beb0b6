"""A log's cells as columns of numbers, and the key columns that a complete log must have."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.groups import TaskGroup, group
from gym_extensions.catalog.protocol import EVALUATION_EPISODES, evaluation_seed

Whole = NDArray[np.int64]
WHOLE = ("run", "stage", "episode", "seed", "length")
FLAGS = {"true": True, "false": False}
DIGITS = 15


@dataclass(frozen=True)
class Cells:
    """The cells of one CSV file as text, by column."""

    path: str
    columns: dict[str, list[str]]


@dataclass(frozen=True)
class Log:
    """The rows of one evaluation log as columns, in the order of the file.

    ``complete`` says that the key columns are exactly those of a complete, sorted log of ``runs``.
    ``position`` is each row's task as an index into the group's tasks, -1 for a task that the group does
    not have.
    """

    path: str
    protocol: str
    group: TaskGroup
    complete: bool
    runs: tuple[int, ...]
    run: Whole
    stage: Whole
    task: list[str]
    position: Whole
    episode: Whole
    seed: Whole
    length: Whole
    return_: NDArray[np.float64]
    terminated: NDArray[np.bool_]
    fingerprint: list[str]

    @property
    def cell(self) -> list[tuple[int, int, str, int]]:
        """Run, stage, task and episode of every row."""
        return list(
            zip(self.run.tolist(), self.stage.tolist(), self.task, self.episode.tolist(), strict=True)
        )

    @property
    def max_steps(self) -> Whole:
        """The time limit of each row's task; 0 for a task that the group does not have."""
        limits = [*(task.max_steps for task in self.group.tasks), 0]
        return np.array(limits, dtype=np.int64)[self.position]


def stages(protocol: str, count: int) -> tuple[int, ...]:
    """The stages that a log of that protocol holds, in a group of that many tasks."""
    return tuple(range(count + 1)) if protocol == "sequential" else (1,)


def per_run(protocol: str, group: TaskGroup) -> int:
    """Rows of one run in a complete log."""
    return len(stages(protocol, len(group.tasks))) * len(group.tasks) * EVALUATION_EPISODES


@dataclass(frozen=True)
class RunKeys:
    """The key columns of one run in a complete, sorted log, as text and as numbers."""

    text: dict[str, list[str]]
    numbers: dict[str, Whole]


@functools.lru_cache(maxsize=128)
def _run_keys(protocol: str, group_id: str) -> RunKeys:
    members = group(group_id).task_ids
    keys = list(product(stages(protocol, len(members)), range(len(members)), range(EVALUATION_EPISODES)))
    seeds = {(j, e): evaluation_seed(group_id, members[j], e) for _, j, e in keys}
    numbers = {
        "stage": [stage for stage, _, _ in keys],
        "position": [position for _, position, _ in keys],
        "episode": [episode for _, _, episode in keys],
        "seed": [seeds[position, episode] for _, position, episode in keys],
    }
    text = {name: list(map(str, numbers[name])) for name in ("stage", "episode", "seed")}
    text["task"] = [members[position] for _, position, _ in keys]
    return RunKeys(text, {name: np.array(column, dtype=np.int64) for name, column in numbers.items()})


def complete_runs(columns: dict[str, list[str]], protocol: str, group: TaskGroup) -> tuple[int, ...] | None:
    """The runs of a log whose key columns are complete and sorted, or None where they are not."""
    size = per_run(protocol, group)
    names = columns["run"][::size]
    if len(columns["run"]) % size or any(not name.isdecimal() or str(int(name)) != name for name in names):
        return None
    runs = tuple(map(int, names))
    if list(runs) != sorted(set(runs)) or columns["run"] != [name for name in names for _ in range(size)]:
        return None
    expected = _run_keys(protocol, group.id).text
    same = all(columns[key] == cells * len(runs) for key, cells in expected.items())
    return runs if same else None


def is_whole(cell: str) -> bool:
    """Whether a cell is a whole number of at most 15 digits."""
    return cell.removeprefix("-").isdecimal() and len(cell) <= DIGITS


def is_number(cell: str) -> bool:
    """Whether a cell is a number, ``nan`` and ``inf`` among them."""
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _whole(cells: list[str]) -> Whole:
    return np.array(list(map(int, cells)), dtype=np.int64)


def _keys(columns: dict[str, list[str]], group: TaskGroup) -> dict[str, Whole]:
    """The key columns as numbers, read cell by cell."""
    places = {task: position for position, task in enumerate(group.task_ids)}
    keys = {name: _whole(columns[name]) for name in ("run", "stage", "episode", "seed")}
    keys["position"] = np.array([places.get(name, -1) for name in columns["task"]], dtype=np.int64)
    return keys


def log(cells: Cells, protocol: str, group: TaskGroup) -> Log:
    """The log of cells; raises ValueError, KeyError or OverflowError for a cell of another kind."""
    columns = cells.columns
    runs = complete_runs(columns, protocol, group)
    if runs is None:
        keys = _keys(columns, group)
    else:
        once = _run_keys(protocol, group.id).numbers
        keys = {name: np.tile(column, len(runs)) for name, column in once.items()}
        keys["run"] = np.repeat(np.array(runs, dtype=np.int64), per_run(protocol, group))
    return Log(
        path=cells.path,
        protocol=protocol,
        group=group,
        complete=runs is not None,
        runs=runs if runs is not None else tuple(sorted(set(keys["run"].tolist()))),
        task=columns["task"],
        length=_whole(columns["length"]),
        return_=np.array(list(map(float, columns["return"])), dtype=np.float64),
        terminated=np.array([FLAGS[cell] for cell in columns["terminated"]], dtype=np.bool_),
        fingerprint=columns["fingerprint"],
        **keys,
    )
