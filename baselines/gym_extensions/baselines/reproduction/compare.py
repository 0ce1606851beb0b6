"""Compares a run's rows of two evaluation logs: the bytes, and else the mean return of every cell."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf, nan, sqrt
from statistics import fmean, variance

from scipy.special import stdtr

ALPHA = 0.05
"""Family-wise error rate over the cells of a run."""

Rows = Sequence[Mapping[str, str]]
"""Rows of a log by column."""


@dataclass(frozen=True)
class Cell:
    """A task after a stage: the mean returns in both logs, and the two-sided p value of Welch's t test."""

    stage: int
    task: str
    logged: float
    retrained: float
    p_value: float
    agrees: bool


@dataclass(frozen=True)
class Comparison:
    """The result of a comparison.

    Args:
        first_difference: the first row and column that differ; empty if the rows are the same bytes.
        cells: the cells whose mean returns were compared; empty if the rows are the same bytes.
    """

    first_difference: str = ""
    cells: tuple[Cell, ...] = ()

    @property
    def same_bytes(self) -> bool:
        """Whether all rows are the same bytes."""
        return not self.first_difference

    @property
    def agrees(self) -> bool:
        """Whether the rows are the same, or the mean returns of all cells agree within evaluation noise."""
        return all(cell.agrees for cell in self.cells)


def compare(logged: Rows, retrained: Rows, columns: Sequence[str]) -> Comparison:
    """Compares the rows of a run.

    The rule for rows that differ: the mean returns of a cell, over its 20 episodes in each log, are compared
    by Welch's t test with the standard errors of the episodes. They agree within evaluation noise unless
    Holm's procedure rejects the cell at the family-wise error rate .05 over all cells of the run. A cell
    without variance in both logs agrees only if the means are equal.

    A cell that one log lacks does not agree.

    Args:
        logged: the rows of the log, in order.
        retrained: the rows of the retrained run, in order.
        columns: the columns that are compared.
    """
    difference = _first_difference(logged, retrained, columns)
    return Comparison(difference, _cells(logged, retrained)) if difference else Comparison()


def _first_difference(logged: Rows, retrained: Rows, columns: Sequence[str]) -> str:
    for old, new in zip(logged, retrained, strict=False):
        for column in columns:
            if old[column] != new[column]:
                where = f"stage {old['stage']}, {old['task']}, episode {old['episode']}"
                return f"{where}: {column} is {old[column]} in the log and {new[column]} after retraining"
    if len(logged) != len(retrained):
        return f"the log has {len(logged)} rows and the retrained run {len(retrained)}"
    return ""


def _cells(logged: Rows, retrained: Rows) -> tuple[Cell, ...]:
    old, new = _returns(logged), _returns(retrained)
    keys = list(dict.fromkeys([*old, *new]))
    p_values = [welch_p(old[key], new[key]) if key in old and key in new else 0.0 for key in keys]
    rejected = set[int]()
    for rank, index in enumerate(sorted(range(len(keys)), key=p_values.__getitem__)):
        if p_values[index] > ALPHA / (len(keys) - rank):
            break
        rejected.add(index)
    return tuple(
        Cell(*key, _mean(old.get(key)), _mean(new.get(key)), p_values[index], index not in rejected)
        for index, key in enumerate(keys)
    )


def _mean(returns: Sequence[float] | None) -> float:
    return fmean(returns) if returns else nan


def _returns(rows: Rows) -> dict[tuple[int, str], list[float]]:
    returns: dict[tuple[int, str], list[float]] = {}
    for row in rows:
        returns.setdefault((int(row["stage"]), row["task"]), []).append(float(row["return"]))
    return returns


def welch_p(a: Sequence[float], b: Sequence[float]) -> float:
    """The two-sided p value of Welch's t test. Without variance it is 1 for equal means, else 0.

    Args:
        a: at least two values.
        b: at least two values.
    """
    difference, squares = fmean(a) - fmean(b), (variance(a) / len(a), variance(b) / len(b))
    total = sum(squares)
    if total == 0:
        return 1.0 if difference == 0 else 0.0
    parts = zip(squares, (a, b), strict=True)
    denominator = sum(square * square / (len(sample) - 1) for square, sample in parts)
    df = total * total / denominator if denominator else inf
    return float(2 * stdtr(df, -abs(difference) / sqrt(total)))
