"""Parses the cells of evaluations.csv, the evaluations during training."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.budgets import Budget
from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.rollouts.reading.evaluation_log import Cells, Integers, Runs


@dataclass(frozen=True)
class Evaluations:
    """The rows of evaluations.csv by column.

    ``runs`` are the runs of each log, ``numbers`` is as in ``Cells``.
    """

    path: str
    group: TaskGroup
    budget: Budget | None
    runs: Runs
    protocol: list[str]
    run: Integers
    stage: Integers
    task: list[str]
    step: Integers
    episodes: Integers
    return_: NDArray[np.float64]
    numbers: Integers | None = None


def evaluations(cells: Cells, group: TaskGroup, budget: Budget | None, runs: Runs) -> Evaluations:
    """Parses the cells. Raises ValueError or OverflowError for a cell of the wrong kind."""
    columns = cells.columns
    integers = {
        name: np.array(list(map(int, columns[name])), dtype=np.int64)
        for name in ("run", "stage", "step", "episodes")
    }
    return Evaluations(
        path=cells.path,
        group=group,
        budget=budget,
        runs=runs,
        protocol=columns["protocol"],
        task=columns["task"],
        return_=np.array(list(map(float, columns["return"])), dtype=np.float64),
        numbers=cells.numbers,
        **integers,
    )
