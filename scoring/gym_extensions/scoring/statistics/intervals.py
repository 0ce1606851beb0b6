"""Student's t over whole runs: the interval of a mean, from a table of quantiles, the same everywhere."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from gym_extensions.scoring.statistics.descriptive import deviation
from gym_extensions.scoring.statistics.quantiles import T_975


@dataclass(frozen=True)
class Interval:
    """A mean with its 95 % interval; ``low`` and ``high`` are None where one run gives none.

    ``error`` is the standard error of the mean and ``freedom`` its degrees of freedom.
    """

    mean: float
    low: float | None = None
    high: float | None = None
    error: float | None = None
    freedom: float | None = None


def quantile(freedom: float) -> float:
    """The .975 quantile of Student's t for at least one degree of freedom, not necessarily whole.

    Between whole degrees it is interpolated in 1/ν, which errs to the wide side (t is convex in 1/ν); beyond
    the table its last entry is kept.
    """
    if freedom < 1:
        raise ValueError(f"{freedom} degrees of freedom.")
    below = min(int(freedom), len(T_975))
    if below == len(T_975) or below == freedom:
        return T_975[below - 1]
    share = (1 / below - 1 / freedom) / (1 / below - 1 / (below + 1))
    return T_975[below - 1] + share * (T_975[below] - T_975[below - 1])


def around(mean: float, error: float, freedom: float) -> Interval:
    """mean ± t(.975, ν) × standard error."""
    half = quantile(freedom) * error
    return Interval(mean, mean - half, mean + half, error, freedom)


def interval(values: Sequence[float]) -> Interval:
    """The mean of one value a run, ± t(.975, N − 1) · s / √N; no interval for one run."""
    centre = math.fsum(values) / len(values)
    if len(values) < 2:
        return Interval(centre)
    return around(centre, deviation(values, lost=1) / math.sqrt(len(values)), len(values) - 1)


@dataclass(frozen=True)
class Summary:
    """A mean over runs as a test needs it: the mean, its squared standard error, degrees of freedom.

    ``runs`` is how many runs it stands on: the fewest, where it is made of several means. With one run there
    is no error: all but ``mean`` and ``runs`` are 0.

    ``variance`` and ``groups`` tell what other numbers of runs would give, today's deviations kept: n runs of
    everything that it is made of have the squared error variance / n and (n − 1) · groups degrees of freedom,
    exactly. ``groups`` is 1 for one group and up to G for the mean over G of them.
    """

    mean: float
    square: float
    freedom: float
    runs: int
    variance: float
    groups: float


def summary(values: Sequence[float]) -> Summary:
    """The summary of one value a run."""
    centre, runs = math.fsum(values) / len(values), len(values)
    if runs < 2:
        return Summary(centre, 0.0, 0.0, runs, 0.0, 0.0)
    spread = deviation(values, lost=1)
    return Summary(centre, spread * spread / runs, runs - 1.0, runs, spread * spread, 1.0)


def summary_of(parts: Sequence[Summary]) -> Summary:
    """The summary of the mean over independent groups: SE² = Σ SE_g² / G², Welch–Satterthwaite."""
    count = len(parts)
    return _made_of(math.fsum(part.mean for part in parts) / count, parts, count)


def less(first: Summary, second: Summary) -> Summary:
    """The summary of first − second, unpaired."""
    return _made_of(first.mean - second.mean, (first, second), 1)


def _made_of(mean: float, parts: Sequence[Summary], count: int) -> Summary:
    runs = min(part.runs for part in parts)
    if runs < 2:
        return Summary(mean, 0.0, 0.0, runs, 0.0, 0.0)
    error, freedom = combined([(part.square / (count * count), part.freedom) for part in parts])
    spread, groups = combined([(part.variance / (count * count), part.groups) for part in parts])
    return Summary(mean, error * error, freedom, runs, spread * spread, groups)


def span(found: Summary) -> Interval:
    """The interval of a summary; none where it stands on one run."""
    if found.runs < 2:
        return Interval(found.mean)
    return around(found.mean, math.sqrt(found.square), found.freedom)


def difference(first: Sequence[float], second: Sequence[float]) -> Interval:
    """The interval of mean(first) − mean(second), runs unpaired: Welch's; none where either has one run."""
    return span(less(summary(first), summary(second)))


def combined(parts: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """Standard error and degrees of freedom (Welch–Satterthwaite) of a sum of independent means.

    Args:
        parts: squared standard error and degrees of freedom of each.
    """
    total = math.fsum(square for square, _ in parts)
    below = math.fsum(square * square / freedom for square, freedom in parts)
    if below == 0:
        return math.sqrt(total), math.fsum(freedom for _, freedom in parts)
    freedom = total * total / below
    return math.sqrt(total), max(freedom, min(freedom for _, freedom in parts))
