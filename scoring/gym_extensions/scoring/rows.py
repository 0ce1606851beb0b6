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
KEYS = ("run", "stage", "task", "episode", "seed")
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
    """

    path: str
    protocol: str
    group: TaskGroup
    complete: bool
    runs: tuple[int, ...]
    run: Whole
    stage: Whole
    task: list[str]
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
        limits = {task.id: task.max_steps for task in self.group.tasks}
        return np.array([limits.get(name, 0) for name in self.task], dtype=np.int64)


def stages(protocol: str, count: int) -> tuple[int, ...]:
    """The stages that a log of that protocol holds, in a group of that many tasks."""
    return tuple(range(count + 1)) if protocol == "sequential" else (1,)


def per_run(protocol: str, group: TaskGroup) -> int:
    """Rows of one run in a complete log."""
    return len(stages(protocol, len(group.tasks))) * len(group.tasks) * EVALUATION_EPISODES


@functools.lru_cache(maxsize=128)
def _run_keys(protocol: str, group_id: str) -> tuple[list[str], list[str], list[str], list[str]]:
    """Stage, task, episode and seed cells of one run of a complete, sorted log."""
    members = group(group_id).task_ids
    keys = list(product(stages(protocol, len(members)), members, range(EVALUATION_EPISODES)))
    seeds = {(task, episode): str(evaluation_seed(group_id, task, episode)) for _, task, episode in keys}
    return (
        [str(stage) for stage, _, _ in keys],
        [task for _, task, _ in keys],
        [str(episode) for _, _, episode in keys],
        [seeds[task, episode] for _, task, episode in keys],
    )


def complete_runs(columns: dict[str, list[str]], protocol: str, group: TaskGroup) -> tuple[int, ...] | None:
    """The runs of a log whose key columns are complete and sorted, or None where they are not."""
    size = per_run(protocol, group)
    names = columns["run"][::size]
    if len(columns["run"]) % size or any(not name.isdecimal() or str(int(name)) != name for name in names):
        return None
    runs = tuple(map(int, names))
    if list(runs) != sorted(set(runs)) or columns["run"] != [name for name in names for _ in range(size)]:
        return None
    expected = _run_keys(protocol, group.id)
    same = all(columns[key] == cells * len(runs) for key, cells in zip(KEYS[1:], expected, strict=True))
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


def log(cells: Cells, protocol: str, group: TaskGroup) -> Log:
    """The log of cells in which no rule found a problem."""
    columns = cells.columns
    runs = complete_runs(columns, protocol, group)
    numbers = {name: _whole(columns[name]) for name in WHOLE}
    return Log(
        path=cells.path,
        protocol=protocol,
        group=group,
        complete=runs is not None,
        runs=runs if runs is not None else tuple(sorted(set(numbers["run"].tolist()))),
        run=numbers["run"],
        stage=numbers["stage"],
        task=columns["task"],
        episode=numbers["episode"],
        seed=numbers["seed"],
        length=numbers["length"],
        return_=np.array(list(map(float, columns["return"])), dtype=np.float64),
        terminated=np.array([FLAGS[cell] for cell in columns["terminated"]], dtype=np.bool_),
        fingerprint=columns["fingerprint"],
    )
