"""A metric's value on a group or suite, with its interval, or the reason why it has none."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

from gym_extensions.scoring.documents import about
from gym_extensions.scoring.statistics.intervals import Interval

LEAST_LEARNED = 0.1
"""Learning performance from which a single run, which has no interval, counts as having learned."""


@dataclass(frozen=True, slots=True)
class MetricValue:
    """Mean over runs, 95 % interval and one value per run."""

    mean: Annotated[float | None, about("mean over runs; null where the metric has no value")] = None
    low: Annotated[float | None, about("lower end of the 95 % interval; null with one run")] = None
    high: Annotated[float | None, about("upper end of the 95 % interval; null with one run")] = None
    runs: Annotated[
        tuple[float, ...],
        about(
            "one value per run, in the order of the group's `runs`; empty for `joint_gap` "
            "(joint and sequential runs are not paired) and in suites"
        ),
    ] = ()
    why: Annotated[str, about("why the mean or the interval is null, as a sentence; else empty")] = ""

    @classmethod
    def of(cls, interval: Interval, runs: tuple[float, ...] = (), why: str = "") -> MetricValue:
        """The value of an interval over runs."""
        return cls(interval.mean, interval.low, interval.high, runs, why)

    @property
    def ends(self) -> tuple[float, float] | None:
        """Both ends of the interval, or None with fewer than two runs."""
        return None if self.low is None or self.high is None else (self.low, self.high)


def learned_nothing(metrics: Mapping[str, MetricValue]) -> bool:
    """Whether an entry learned nothing that it could forget.

    True where the interval of learning performance does not lie above 0; with one run, which has no
    interval, where the value is below .1 (docs/metrics.md, "How boards are read").
    """
    learning = metrics.get("learning_performance", MetricValue())
    if learning.mean is None:
        return False
    return learning.mean < LEAST_LEARNED if learning.low is None else learning.low <= 0
