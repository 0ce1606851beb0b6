"""Entries of one group compared with one of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from gym_extensions.scoring.statistics import (
    Interval,
    difference,
    holm,
    interval,
    summary,
    two_sided_p,
    welch,
    zero_mean_p,
)

METRICS = ("learning_performance", "final_performance", "forgetting")


@dataclass(frozen=True)
class Verdict:
    """An entry minus another in one metric, and whether the corrected test separates the two."""

    gap: Interval
    is_separated: bool


@dataclass(frozen=True)
class Row:
    """One entry on one group: the values of its runs, and intervals that contain the error of the experts.

    Without ``intervals``, they are those over the runs alone.
    """

    name: str
    title: str
    observes_task: bool
    values: tuple[Sequence[float], ...]
    final_verdict: Verdict | None = None
    forgetting_verdict: Verdict | None = None
    intervals: tuple[Interval, ...] = ()

    def _interval(self, at: int) -> Interval:
        return self.intervals[at] if self.intervals else interval(self.values[at])

    @property
    def runs(self) -> int:
        """Number of runs."""
        return len(self.values[0])

    @property
    def learned(self) -> Interval:
        """Score right after training on a task."""
        return self._interval(0)

    @property
    def final(self) -> Interval:
        """Score of all tasks at the end."""
        return self._interval(1)

    @property
    def forgetting(self) -> Interval:
        """Score that was lost in between."""
        return self._interval(2)


@dataclass(frozen=True)
class Count:
    """How many entries are separated from fine-tuning in one metric, over all groups."""

    metric: str
    above: int
    below: int
    comparisons: int

    @property
    def ties(self) -> int:
        """Comparisons that the test does not separate."""
        return self.comparisons - self.above - self.below


def with_verdicts(first: Row, others: Sequence[Row]) -> tuple[Row, ...]:
    """``others`` with their verdicts against ``first``.

    Welch's test, with Holm's correction over ``others``, in each of the two metrics.
    """
    final, lost = (_verdicts(first.values[at], [row.values[at] for row in others]) for at in (1, 2))
    return tuple(
        replace(row, final_verdict=one, forgetting_verdict=other)
        for row, one, other in zip(others, final, lost, strict=True)
    )


def _verdicts(first: Sequence[float], others: Sequence[Sequence[float]]) -> list[Verdict]:
    p_values = [float(two_sided_p(*welch([summary(runs), summary(first)]))[0]) for runs in others]
    separated = holm(np.array(p_values, dtype=np.float64))
    pairs = zip(others, separated, strict=True)
    return [Verdict(difference(runs, first), bool(apart)) for runs, apart in pairs]


def separated_from_zero(runs: Mapping[str, Sequence[float]]) -> set[str]:
    """The groups whose mean over runs differs from 0, by t tests with Holm's correction over them."""
    p_values = [zero_mean_p(summary(values)) for values in runs.values()]
    rejected = holm(np.array(p_values, dtype=np.float64))
    return {name for name, is_rejected in zip(runs, rejected, strict=True) if is_rejected}


def count(metric: str, verdicts: Sequence[Verdict | None]) -> Count:
    """The verdicts of one metric, counted."""
    present = [verdict for verdict in verdicts if verdict is not None]
    signs = [verdict.gap.mean > 0 for verdict in present if verdict.is_separated]
    return Count(metric, sum(signs), len(signs) - sum(signs), len(present))
