"""Welch's test of every pair of a board's entries, on columns: a thousand entries have half a million pairs.

The p values here are good to 1e-6 of themselves, and serve to order the pairs; a pair that comes close
to the limit is decided by ``student.two_sided_p``, so that no result hangs on numpy's exp and log.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gym_extensions.scoring.statistics.intervals import Summary
from gym_extensions.scoring.statistics.student_t import coefficient, critical, two_sided_p

Column = NDArray[np.float64]
Index = int | NDArray[np.intp]

HOPELESS = 1.9
"""A |t| below it has p > .05 at any degrees of freedom, and is not looked up: the normal quantile is 1.96."""
NO_PAIR = 2.0
"""In the place of a p value where there is no pair, or the pair stands in the other order."""
CLOSE = 1e-5
"""So near to its limit, in parts of it, a p value is looked up exactly."""
NODES = 16384
"""Between so many values of a the logarithm of the gamma functions is interpolated.

It bends like log a / 2, so between nodes h apart it is off by (h/a)²/16, and by at most (h/a)²/9 at a = 1/2:
the nodes are a geometric progression, where h/a is the same everywhere. From 1 to 40,000 degrees of freedom
that is 5e-8, however unequal a board's entries are.
"""
CHUNK = 65536
"""So many pairs at once, whose columns stay in a processor's cache."""
TERMS = 100
PRECISION = 1e-10
"""Where a factor of the continued fraction is so near to 1 it ends: 2e-8 from its value at 2000 degrees of
freedom, 2e-7 at 80,000 (measured)."""


@dataclass(frozen=True)
class Pairs:
    """What Welch's test needs of every entry, as columns: means, their squared errors, degrees of freedom."""

    mean: Column
    square: Column
    freedom: Column

    def welch(self, a: Index, b: Index) -> tuple[Column, Column]:
        """Welch's t and its degrees of freedom of entries a against b, indices that broadcast.

        t is ±∞ for different means without variance, and 0 for equal means.
        """
        gap, total = self.mean[a] - self.mean[b], self.square[a] + self.square[b]
        one, other = self.freedom[a], self.freedom[b]
        below = self.square[a] * self.square[a] / one + self.square[b] * self.square[b] / other
        with np.errstate(divide="ignore", invalid="ignore"):
            t = np.where(gap == 0, 0.0, gap / np.sqrt(total))
            pooled = np.maximum(total * total / below, np.minimum(one, other))
        return t, np.where(below == 0, one + other, pooled)

    def exact(self, a: int, b: int) -> float:
        """The two-sided p value of one pair; 1 where |t| is too small to matter at 5 %."""
        t, freedom = (float(found) for found in self.welch(a, b))
        return 1.0 if abs(t) < HOPELESS else two_sided_p(t, freedom)

    def quick(self, level: float) -> Column:
        """Nearly the p value of every pair that Holm's procedure may reject, [a, b] for a < b.

        1 for the other pairs, and ``NO_PAIR`` where there is none.
        """
        entries = self.mean.size
        size, freedom = np.zeros((entries, entries)), np.ones((entries, entries))
        rows = max(1, CHUNK // entries)
        for first in range(0, entries, rows):
            block = slice(first, first + rows)
            t, freedom[block] = self.welch(np.arange(entries)[block, None], np.arange(entries))
            size[block] = np.abs(t)
        found = np.triu(np.ones((entries, entries)), 1) + np.tril(np.full((entries, entries), NO_PAIR))
        size[found > 1] = 0
        found[np.isinf(size)] = 0
        asked = np.flatnonzero((size >= self._least(size, level)) & np.isfinite(size))
        if asked.size:
            nodes = np.geomspace(self.freedom.min() / 2, self.freedom.max(), NODES)
            scales = [math.lgamma(a + 0.5) - math.lgamma(a) - math.lgamma(0.5) for a in nodes.tolist()]
            for chunk in np.split(asked, range(CHUNK, asked.size, CHUNK)):
                half = freedom.flat[chunk] / 2
                found.flat[chunk] = _tail(size.flat[chunk], half, np.interp(half, nodes, scales))
        return found

    def _least(self, size: Column, level: float) -> float:
        """A |t| that every pair reaches which Holm's procedure rejects.

        It rejects at most those that reach some |t|. So no limit is above the level over the number of the
        others, and all that it rejects reach the critical value of that limit at the most degrees of freedom.
        """
        count, most = self.mean.size * (self.mean.size - 1) // 2, 2 * float(self.freedom.max())
        least = HOPELESS
        while True:
            able = int(np.count_nonzero(size >= least))
            higher = critical(level / max(1, count - able), most) * (1 - CLOSE)
            if higher <= least:
                return least
            least = higher


def pairs(entries: Sequence[Summary]) -> Pairs:
    """The entries' summaries as columns."""
    return Pairs(
        *(np.array([getattr(one, name) for one in entries]) for name in ("mean", "square", "freedom"))
    )


def _tail(t: Column, a: Column, scale: Column) -> Column:
    """I_x(a, 1/2) at x = 2a / (2a + t²) for |t| ≥ 1.9, where the continued fraction needs no reflection.

    ``a`` is half the degrees of freedom, ``scale`` the logarithm of Γ(a + 1/2) / Γ(a) Γ(1/2).
    """
    b, x = 0.5, 2 * a / (2 * a + t * t)
    front = np.exp(a * np.log(x) + b * np.log1p(-x) + scale)
    value, above, below = np.ones_like(x), np.ones_like(x), np.zeros_like(x)
    for term in range(1, TERMS):
        d = coefficient(term, a, b, x)
        below, above = 1 / (1 + d * below), 1 + d / above
        change = above * below
        value *= change
        if not (np.abs(change - 1) >= PRECISION).any():
            break
    tail: Column = front / (value * a)
    return tail
