"""Whether logged returns are higher than returns on new seeds, by a permutation test.

Under the null hypothesis the logged and the new seeds of a task are exchangeable: both are drawn from the
same distribution, and the policies were fixed before the new ones. All runs, stages and protocols of a task
are evaluated on the same seeds, and tasks may be much harder from some of them, so that returns of one seed
are not independent. The test therefore exchanges seeds and not returns, which makes it exact for any
dependence between runs: it rejects an honest entry with a probability of at most ``ALPHA``. An agent may draw
the same noise in all tasks, so that episodes of one number are not independent either: the same numbers are
exchanged in all tasks. The new episodes do not share noise between tasks; the numbers of both kinds are
equal, so the test is then exact in the limit of many episodes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

ALPHA = 0.004
"""Probability of rejecting an honest entry."""
PERMUTATIONS = 4999
STATISTICS = 3
"""Tests of an entry: all cells, the largest run and the largest cell. Their p values are multiplied by it."""


@dataclass(frozen=True)
class TaskReturns:
    """The returns of the cells of one task.

    Args:
        runs: the run of each cell, as an index over all runs of all logs of the entry.
        logged: (cells, prescribed seeds).
        fresh: (cells, new seeds).
    """

    runs: Sequence[int]
    logged: Array
    fresh: Array


@dataclass(frozen=True)
class Comparison:
    """The adjusted one-sided p value, and whether it is above ``ALPHA``: the log agrees with the policies."""

    p_value: float

    @property
    def agrees(self) -> bool:
        """Whether the logged returns are not significantly higher than those on new seeds."""
        return self.p_value > ALPHA


def compare(tasks: Sequence[TaskReturns], rng: np.random.Generator) -> Comparison:
    """Compares logged and new returns of all cells.

    A cell's difference is the difference of its two means over the standard deviation of its returns. The
    statistics are the sum over all cells, the largest sum over the cells of a run divided by the square root
    of their number, and the largest of a cell. The p value is the smallest of the three times three
    (Bonferroni).

    Args:
        tasks: the cells by task.
        rng: draws the permutations.

    All tasks have the same numbers of logged and new episodes.
    """
    if not tasks:
        return Comparison(1.0)
    weights = _weights(tasks[0], rng)
    differences = np.concatenate([_differences(task, weights) for task in tasks])
    runs = np.concatenate([np.asarray(task.runs) for task in tasks])
    sums = np.stack([differences[runs == run].sum(axis=0) for run in np.unique(runs)])
    sizes = np.array([(runs == run).sum() for run in np.unique(runs)])
    statistics = (
        differences.sum(axis=0),
        (sums / np.sqrt(sizes)[:, None]).max(axis=0),
        differences.max(axis=0),
    )
    p_values = [float((values >= values[0] - ROUNDING).mean()) for values in statistics]
    return Comparison(min(1.0, STATISTICS * min(p_values)))


ROUNDING = 1e-9
"""Statistics that differ by less are equal."""


def _weights(task: TaskReturns, rng: np.random.Generator) -> Array:
    """Weights (1 + permutations, logged and new episodes) of a difference of means; the data's first."""
    logged, fresh = task.logged.shape[1], task.fresh.shape[1]
    weights = np.concatenate([np.full(logged, 1 / logged), np.full(fresh, -1 / fresh)])
    exchanged = rng.permuted(np.tile(weights, (PERMUTATIONS, 1)), axis=1)
    return np.concatenate([weights[None], exchanged])


def _differences(task: TaskReturns, weights: Array) -> Array:
    """The difference of every cell (cells, 1 + permutations); the first column is that of the data."""
    returns = np.concatenate([task.logged, task.fresh], axis=1)
    deviation = returns.std(axis=1, keepdims=True)
    is_constant = deviation <= ROUNDING * np.maximum(1.0, np.abs(returns).max(axis=1, keepdims=True))
    standardized = np.where(is_constant, 0.0, returns / np.where(is_constant, 1.0, deviation))
    result: Array = standardized @ weights.T
    return result
