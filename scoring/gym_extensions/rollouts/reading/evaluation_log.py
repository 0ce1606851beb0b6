"""A log's cells as columns of numbers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.groups import TaskGroup

Whole = NDArray[np.int64]
WHOLE = ("run", "stage", "episode", "seed", "length")
FLAGS = {"true": True, "false": False}
DIGITS = 15

Runs = dict[str, tuple[int, ...] | None]
"""The runs of each log that is there, by protocol; None where they cannot be known."""


@dataclass(frozen=True)
class Cells:
    """The cells of one CSV file as text, by column.

    ``numbers`` are the rows' places in the file, from 0 (None: all rows of the file are there); ``unread``
    counts the rows that are not there because they cannot be read.
    """

    path: str
    columns: dict[str, list[str]]
    numbers: Whole | None = None
    unread: int = 0


@dataclass(frozen=True)
class Log:
    """The rows of one evaluation log as columns, in the order of the file.

    ``position`` is each row's task as an index into the group's tasks, -1 for a task that the group does
    not have. ``numbers`` and ``unread`` are as those of ``Cells``.
    """

    path: str
    protocol: str
    group: TaskGroup
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
    numbers: Whole | None = None
    unread: int = 0

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


def is_whole(cell: str) -> bool:
    """Whether a cell is a whole number of at most 15 digits."""
    return cell.removeprefix("-").isdecimal() and len(cell) <= DIGITS


def is_number(cell: str) -> bool:
    """Whether a cell is a number, ``nan`` and ``inf`` among them."""
    try:
        float(cell)
    except ValueError:
        return False
    return "_" not in cell


KINDS: dict[str, tuple[Callable[[str], bool], str]] = {
    **dict.fromkeys((*WHOLE, "step"), (is_whole, "a whole number")),
    "return": (is_number, "a number"),
    "terminated": (FLAGS.__contains__, "true or false"),
}
"""How a cell of a column is told to be of its kind, and what is written there."""


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
    keys = _keys(columns, group)
    return Log(
        path=cells.path,
        protocol=protocol,
        group=group,
        runs=tuple(sorted(set(keys["run"].tolist()))),
        task=columns["task"],
        length=_whole(columns["length"]),
        return_=np.array(list(map(float, columns["return"])), dtype=np.float64),
        terminated=np.array([FLAGS[cell] for cell in columns["terminated"]], dtype=np.bool_),
        fingerprint=columns["fingerprint"],
        numbers=cells.numbers,
        unread=cells.unread,
        **keys,
    )
