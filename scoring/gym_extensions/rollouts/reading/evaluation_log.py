"""Parses the cells of an evaluation log into columns, and compares its keys with the prescribed ones."""

from __future__ import annotations

import functools
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import product

import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.fingerprints import published
from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.catalog.protocol import EVALUATION_EPISODES, evaluation_seed, stages
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.auditing.digests import DIGEST

Integers = NDArray[np.int64]
INTEGER_COLUMNS = ("run", "stage", "episode", "seed", "length")
FLAGS = {"true": True, "false": False}
SUCCESSES = {"true": 1, "false": 0, "": -1}
"""The number of each cell of the column ``success``: -1 where the task defines none."""
MAX_DIGITS = 15

Runs = dict[str, tuple[int, ...] | None]
"""The runs of each log of a group, by protocol; None where they are unknown."""


@dataclass(frozen=True)
class Cells:
    """The cells of a CSV file as text, by column.

    ``numbers`` are the indices in the file of the rows that were read, from 0 (None: all rows were read);
    ``unread`` counts the rows that could not be read.
    """

    path: str
    columns: dict[str, list[str]]
    numbers: Integers | None = None
    unread: int = 0


@dataclass(frozen=True)
class Log:
    """The rows of an evaluation log by column, in the order of the file.

    ``position`` is the index of each row's task in the group, -1 for a task of another group. ``success`` is
    1, 0, or -1 where the cell is empty. ``trace`` has the digests of the traces, or nothing if the
    log has no such column. ``numbers`` and ``unread`` are as in ``Cells``.
    """

    path: str
    protocol: str
    group: TaskGroup
    runs: tuple[int, ...]
    run: Integers
    stage: Integers
    task: list[str]
    position: Integers
    episode: Integers
    seed: Integers
    length: Integers
    return_: NDArray[np.float64]
    terminated: NDArray[np.bool_]
    success: NDArray[np.int8]
    fingerprint: list[str]
    numbers: Integers | None = None
    unread: int = 0
    trace: list[str] = field(default_factory=list)

    @property
    def episode_keys(self) -> list[tuple[int, int, str, int]]:
        """Run, stage, task and episode of every row."""
        return list(
            zip(self.run.tolist(), self.stage.tolist(), self.task, self.episode.tolist(), strict=True)
        )

    @property
    def max_steps(self) -> Integers:
        """The time limit of each row's task in steps, 0 for a task of another group."""
        limits = [*(task.max_steps for task in self.group.tasks), 0]
        return np.array(limits, dtype=np.int64)[self.position]


def is_integer(cell: str) -> bool:
    """Whether a cell is an integer of at most 15 digits."""
    return cell.removeprefix("-").isdecimal() and len(cell) <= MAX_DIGITS


def is_number(cell: str) -> bool:
    """Whether a cell is a number, ``nan`` and ``inf`` included."""
    try:
        float(cell)
    except ValueError:
        return False
    return "_" not in cell


def is_digest(cell: str) -> bool:
    """Whether a cell is the digest of a trace."""
    return DIGEST.fullmatch(cell) is not None


KINDS: dict[str, tuple[Callable[[str], bool], str]] = {
    **dict.fromkeys((*INTEGER_COLUMNS, "step", "episodes"), (is_integer, "an integer")),
    "return": (is_number, "a number"),
    "terminated": (FLAGS.__contains__, "true or false"),
    "success": (SUCCESSES.__contains__, "true, false or nothing"),
    "trace": (is_digest, "32 hexadecimal digits (0 to 9, a to f)"),
}
"""By column: the test of a cell, and what it must be, in words."""


def _integers(cells: list[str]) -> Integers:
    return np.array(list(map(int, cells)), dtype=np.int64)


def _digests(cells: list[str]) -> list[str]:
    if not all(map(is_digest, cells)):
        raise ValueError("A cell is not the digest of a trace.")
    return cells


def log(cells: Cells, protocol: str, group: TaskGroup) -> Log:
    """Parses the cells into a log.

    Raises ValueError, KeyError or OverflowError for a cell of the wrong kind.
    """
    columns = cells.columns
    positions = {task: position for position, task in enumerate(group.task_ids)}
    integers = {name: _integers(columns[name]) for name in INTEGER_COLUMNS}
    return Log(
        path=cells.path,
        protocol=protocol,
        group=group,
        runs=tuple(np.unique(integers["run"]).tolist()),
        task=list(map(sys.intern, columns["task"])),
        position=np.array([positions.get(name, -1) for name in columns["task"]], dtype=np.int64),
        return_=np.array(list(map(float, columns["return"])), dtype=np.float64),
        terminated=np.array([FLAGS[cell] for cell in columns["terminated"]], dtype=np.bool_),
        success=np.array([SUCCESSES[cell] for cell in columns["success"]], dtype=np.int8),
        trace=_digests(columns.get("trace", [])),
        fingerprint=list(map(sys.intern, columns["fingerprint"])),
        numbers=cells.numbers,
        unread=cells.unread,
        **integers,
    )


@functools.lru_cache(maxsize=128)
def _prescribed(protocol: str, group: TaskGroup) -> tuple[dict[str, Integers], list[str]]:
    """The key columns and fingerprints of one run. Raises BenchError if a fingerprint is not published."""
    ids = group.task_ids
    cells = stages(protocol, len(ids)), range(len(ids)), range(EVALUATION_EPISODES)
    keys = np.array(list(product(*cells)), dtype=np.int64)
    columns = dict(zip(("stage", "position", "episode"), keys.T, strict=True))
    seeds = [[evaluation_seed(group.id, task, episode) for episode in cells[2]] for task in ids]
    columns["seed"] = np.array(seeds, dtype=np.int64)[columns["position"], columns["episode"]]
    fingerprints = [published(task) for task in ids]
    return columns, [fingerprints[position] for position in columns["position"].tolist()]


def has_prescribed_keys(log: Log) -> bool:
    """Whether the key columns are exactly those that the protocol prescribes for the log's runs."""
    try:
        columns, fingerprints = _prescribed(log.protocol, log.group)
    except BenchError:
        return False
    count = len(log.runs)
    expected = {name: np.tile(column, count) for name, column in columns.items()}
    expected["run"] = np.repeat(np.array(log.runs, dtype=np.int64), len(fingerprints))
    is_equal = all(np.array_equal(getattr(log, name), column) for name, column in expected.items())
    return is_equal and log.fingerprint == fingerprints * count
