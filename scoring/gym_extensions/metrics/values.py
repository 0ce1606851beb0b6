"""The value of a metric over runs: a mean with its interval, to which the errors of experts contribute."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Self

from gym_extensions.documents import about
from gym_extensions.metrics.formulas import LEARNING, Metric, NormalizedRun
from gym_extensions.metrics.statistics import Interval, subtract, summary, to_interval

ALL_OPEN = "Every task of this group is open: no expert is known that is clearly better than the floor."
NO_TERM = "No task with an expert meets the formula's condition on j."
TOO_FEW_POINTS = "A training curve that it needs is missing or has fewer than 10 points."
ONE_RUN = "One run has no interval."
NOTHING_LEARNED = "nothing learned to forget"
LITTLE_LEARNED = "little learned: less than each task alone"
LEAST_LEARNED = 0.1
"""Learning performance from which a single run, which has no interval, counts as having learned."""

ExpertError = tuple[float, float]
"""The standard error of an expert's mean return in spans from floor to expert, and its df."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """A mean over runs and its 95 % interval: what every number with an uncertainty is."""

    mean: Annotated[float | None, about("mean over runs; null without a value")] = None
    low: Annotated[float | None, about("lower end of the 95 % interval; null with one run")] = None
    high: Annotated[float | None, about("upper end of the 95 % interval; null with one run")] = None

    @property
    def ends(self) -> tuple[float, float] | None:
        """Both ends of the interval, or None with fewer than two runs."""
        return None if self.low is None or self.high is None else (self.low, self.high)


@dataclass(frozen=True, slots=True)
class MetricValue(Estimate):
    """A metric of a submission: mean over runs, 95 % interval and one value per run."""

    runs: Annotated[tuple[float, ...], about("of each run that has what it needs; none in suites")] = ()
    why: Annotated[str, about("why the mean or the interval is null, as a sentence; else empty")] = ""
    expert_errors: Annotated[tuple[float, ...], about("each expert's error in the mean, by task")] = ()

    @classmethod
    def of(cls, interval: Interval, runs: Sequence[float] = (), expert_errors: Sequence[float] = ()) -> Self:
        """The value of an interval over runs, which a single run does not have."""
        why = ONE_RUN if interval.low is None else ""
        return cls(interval.mean, interval.low, interval.high, tuple(runs), why, tuple(expert_errors))


def learned_nothing(metrics: Mapping[str, Estimate]) -> bool:
    """Whether a submission learned nothing that it could forget (docs/metrics.md, "How boards are read").

    True where the interval of learning performance does not lie above 0; with one run, where the value is
    below .1.
    """
    learning = metrics.get(LEARNING.name, Estimate())
    if learning.mean is None:
        return False
    return learning.mean < LEAST_LEARNED if learning.low is None else learning.low <= 0


def retention_note(metrics: Mapping[str, Estimate], alone: Estimate) -> str:
    """Why little forgetting of a submission is no retention; empty if it is.

    It learned nothing, or little: the interval of its learning performance lies below that of ``alone``, the
    reference agent that is trained on each task alone.
    """
    if learned_nothing(metrics):
        return NOTHING_LEARNED
    learning, least = metrics.get(LEARNING.name, Estimate()).ends, alone.ends
    return LITTLE_LEARNED if learning and least and learning[1] < least[0] else ""


def over_runs(
    metric: Metric, runs: Sequence[NormalizedRun], experts: Sequence[ExpertError] = ()
) -> MetricValue:
    """The value of a metric that is a function of one run, over runs, or why there is none.

    ``experts`` has the error of every task's expert; without them the interval is that over runs alone.
    """
    values: list[float] = []
    for run in runs:
        try:
            value = metric.of_run(run)
        except KeyError:
            if "curves" not in metric.needs:
                raise
            return MetricValue(why=TOO_FEW_POINTS)
        if value is None:
            return MetricValue(why=NO_TERM if run.scored else ALL_OPEN)
        values.append(value)
    errors = expert_errors(metric, runs, experts)
    return MetricValue.of(to_interval(summary(values), error_terms(errors, experts)), values, errors)


def expert_errors(
    metric: Metric, runs: Sequence[NormalizedRun], experts: Sequence[ExpertError]
) -> list[float]:
    """What the error of each task's expert adds to the standard error of a metric's mean over runs.

    By the delta method it is the task's share of the mean times the expert's standard error in spans: of
    final performance, mean(p[T][j]) / T · standard error / (expert − floor). It has the share's sign. Empty
    if no expert has an error.
    """
    if not any(error for error, _ in experts):
        return []
    shares = [metric.shares(run) for run in runs]
    means = [
        math.fsum(share.get(j, 0.0) for share in shares) / len(shares) for j in range(1, len(experts) + 1)
    ]
    return [share * error for share, (error, _) in zip(means, experts, strict=True)]


def error_terms(errors: Iterable[float], experts: Iterable[ExpertError]) -> list[tuple[float, float]]:
    """The squared errors of :func:`expert_errors` with their degrees of freedom."""
    return [(error * error, df) for error, (_, df) in zip(errors, experts, strict=False)]


def joint_gap(final: MetricValue, joint: MetricValue, experts: Sequence[ExpertError] = ()) -> MetricValue:
    """Joint minus sequential final performance. Runs are not paired, so the interval is Welch's."""
    if not final.runs or not joint.runs:
        return MetricValue(why=final.why or joint.why)
    errors = [b - a for a, b in zip(final.expert_errors, joint.expert_errors, strict=True)]
    gap = to_interval(subtract(summary(joint.runs), summary(final.runs)), error_terms(errors, experts))
    return MetricValue.of(gap, expert_errors=errors)
