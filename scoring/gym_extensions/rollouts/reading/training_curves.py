"""Parses the cells of curves.csv into training curves."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.budgets import Budget
from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.rollouts.reading.evaluation_log import Cells, Integers, Runs

Key = tuple[str, int, str]
"""Protocol, run and task id of a curve."""


@dataclass(frozen=True)
class Curves:
    """The rows of curves.csv by column. ``runs`` are the runs of each log, ``numbers`` is as in ``Cells``."""

    path: str
    group: TaskGroup
    budget: Budget | None
    runs: Runs
    protocol: list[str]
    run: list[int]
    task: list[str]
    step: Integers
    return_: NDArray[np.float64]
    numbers: Integers | None = None

    @functools.cached_property
    def blocks(self) -> list[tuple[Key, int, int]]:
        """The key, first row, and row after the last of each curve, in the order of the file."""
        keys = list(zip(self.protocol, self.run, self.task, strict=True))
        starts = [row for row, key in enumerate(keys) if row == 0 or key != keys[row - 1]]
        return [
            (keys[start], start, stop) for start, stop in zip(starts, [*starts[1:], len(keys)], strict=True)
        ]


def curves(cells: Cells, group: TaskGroup, budget: Budget | None, runs: Runs) -> Curves:
    """Parses the cells into curves. Raises ValueError or OverflowError for a cell of the wrong kind."""
    columns = cells.columns
    integers = {cell: int(cell) for cell in set(columns["run"])}
    return Curves(
        path=cells.path,
        group=group,
        budget=budget,
        runs=runs,
        protocol=columns["protocol"],
        run=[integers[cell] for cell in columns["run"]],
        task=columns["task"],
        step=np.array(list(map(int, columns["step"])), dtype=np.int64),
        return_=np.array(list(map(float, columns["return"])), dtype=np.float64),
        numbers=cells.numbers,
    )
