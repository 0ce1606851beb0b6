"""Welch's t test of every pair of entries on a board, with Holm's correction."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from gym_extensions.scoring.statistics.intervals import Summary
from gym_extensions.scoring.statistics.student_t import two_sided_p

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Places = NDArray[np.int64]
ALPHA = 0.05
"""Family-wise error rate of a board."""
NEAR = 0.99
"""Relative margin for rounding where p values need not be computed."""


@lru_cache(maxsize=2)
def _pairs(count: int) -> tuple[Places, Places]:
    """Both entries of all pairs a < b."""
    a, b = np.triu_indices(count, 1)
    return a, b


def welch(entries: Sequence[Summary]) -> tuple[Array, Array]:
    """Welch's t and degrees of freedom of all pairs a < b, in the order of ``numpy.triu_indices(M, 1)``.

    Without variance t is 0 for equal means and ±∞ for different ones. The degrees of freedom are at least the
    smaller ones of the pair, whatever underflows.

    Args:
        entries: M summaries of at least two runs each.
    """
    columns = [(entry.mean, entry.squared_error, entry.df) for entry in entries]
    mean, square, df = np.array(columns, dtype=np.float64).reshape(-1, 3).T
    a, b = _pairs(len(entries))
    difference, total = mean[a] - mean[b], square[a] + square[b]
    part = square * square / df
    denominator = part[a] + part[b]
    with np.errstate(divide="ignore", invalid="ignore"):
        t = np.where(difference == 0, 0.0, difference / np.sqrt(total))
        pooled = np.maximum(total * total / denominator, np.minimum(df[a], df[b]))
    return t, np.where(denominator == 0, df[a] + df[b], pooled)


def holm(p_values: Array, alpha: float = ALPHA) -> Mask:
    """Which hypotheses Holm's step-down procedure rejects at the family-wise error rate ``alpha``."""
    order = np.argsort(p_values)
    rejected = np.zeros(p_values.shape, dtype=np.bool_)
    limits = alpha / np.arange(p_values.size, 0, -1)
    rejected[order] = np.logical_and.accumulate(p_values[order] <= limits)
    return rejected


def significant_pairs(entries: Sequence[Summary], alpha: float = ALPHA) -> Mask:
    """A symmetric M × M matrix, True where Welch's test with Holm's correction separates two entries."""
    t, df = welch(entries)
    # Below the normal quantile, p exceeds alpha for any df, and Holm rejects nothing above alpha.
    possible = np.abs(t) > NEAR * -ndtri(alpha / 2)
    p_values = np.ones_like(t)
    p_values[possible] = two_sided_p(t[possible], df[possible])
    matrix = np.zeros((len(entries), len(entries)), dtype=np.bool_)
    matrix[_pairs(len(entries))] = holm(p_values, alpha)
    return matrix | matrix.T
