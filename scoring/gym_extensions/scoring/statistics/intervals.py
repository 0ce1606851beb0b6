"""Confidence intervals by Student's t over whole runs, for a mean, a mean of groups and a difference."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

from gym_extensions.scoring.statistics.descriptive import standard_deviation
from gym_extensions.scoring.statistics.student_t import quantile


@dataclass(frozen=True)
class Interval:
    """A mean with its 95 % confidence interval.

    Attributes:
        mean: the estimate.
        low: lower end; None if a single run leaves the interval undefined.
        high: upper end; None if ``low`` is None.
        standard_error: of the mean; None if ``low`` is None.
        df: degrees of freedom of the standard error; None if ``low`` is None.
    """

    mean: float
    low: float | None = None
    high: float | None = None
    standard_error: float | None = None
    df: float | None = None


@dataclass(frozen=True)
class Summary:
    """A mean over runs with what intervals, tests and power need.

    With one run there is no standard error: all fields but ``mean`` and ``runs`` are 0.

    Attributes:
        mean: the estimate.
        squared_error: the squared standard error of the mean.
        df: degrees of freedom of the standard error.
        runs: number of runs; the smallest number for a combination of means.
        variance: n runs per part would have the squared error ``variance`` / n, at today's deviations.
        groups: n runs per part would have (n − 1) · ``groups`` degrees of freedom. It is 1 for one group and
            at most G for a mean of G groups.
    """

    mean: float
    squared_error: float
    df: float
    runs: int
    variance: float
    groups: float


@lru_cache(maxsize=1024)
def rounded_quantile(df: float) -> float:
    """The .975 quantile of Student's t, rounded to 12 significant digits.

    The last bits of a library's quantile depend on the processor and the build. Everything else in an
    interval (``math.fsum``, products, quotients, square roots) is exact or correctly rounded by IEEE 754, so
    with a rounded quantile the ends of an interval have the same bits on every machine.

    Raises:
        ValueError: ``df`` is below 1.
    """
    if not df >= 1:
        raise ValueError(f"An interval needs at least 1 degree of freedom, got {df}.")
    return float(f"{quantile(0.975, df):.12g}")


def interval_from_error(mean: float, standard_error: float, df: float) -> Interval:
    """mean ± t(.975, df) · standard error."""
    half_width = rounded_quantile(df) * standard_error
    return Interval(mean, mean - half_width, mean + half_width, standard_error, df)


def interval(values: Sequence[float]) -> Interval:
    """The mean of one value per run, ± t(.975, N − 1) · s / √N. A single run has no interval."""
    mean = math.fsum(values) / len(values)
    if len(values) < 2:
        return Interval(mean)
    error = standard_deviation(values, ddof=1) / math.sqrt(len(values))
    return interval_from_error(mean, error, len(values) - 1)


def difference(first: Sequence[float], second: Sequence[float]) -> Interval:
    """Welch's unpaired interval of mean(first) − mean(second). There is none if either has a single run."""
    return to_interval(subtract(summary(first), summary(second)))


def summary(values: Sequence[float]) -> Summary:
    """The summary of one value per run."""
    mean, runs = math.fsum(values) / len(values), len(values)
    if runs < 2:
        return Summary(mean, 0.0, 0.0, runs, 0.0, 0.0)
    deviation = standard_deviation(values, ddof=1)
    return Summary(mean, deviation * deviation / runs, runs - 1.0, runs, deviation * deviation, 1.0)


def mean_of_groups(groups: Sequence[Summary]) -> Summary:
    """The summary of the mean over independent groups, with SE² = Σ SE_g² / G² and Welch–Satterthwaite df."""
    count = len(groups)
    return _combine(math.fsum(group.mean for group in groups) / count, groups, count)


def subtract(first: Summary, second: Summary) -> Summary:
    """The summary of first − second, unpaired."""
    return _combine(first.mean - second.mean, (first, second), 1)


def to_interval(estimate: Summary) -> Interval:
    """The interval of a summary. A single run has no interval."""
    if estimate.runs < 2:
        return Interval(estimate.mean)
    return interval_from_error(estimate.mean, math.sqrt(estimate.squared_error), estimate.df)


def welch_satterthwaite(terms: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """Standard error and degrees of freedom of a sum of independent means.

    Args:
        terms: squared standard error and degrees of freedom of each mean.
    """
    total = math.fsum(square for square, _ in terms)
    denominator = math.fsum(square * square / df for square, df in terms)
    if denominator == 0:
        return math.sqrt(total), math.fsum(df for _, df in terms)
    df = total * total / denominator
    return math.sqrt(total), max(df, min(df for _, df in terms))


def _combine(mean: float, parts: Sequence[Summary], divisor: int) -> Summary:
    runs = min(part.runs for part in parts)
    if runs < 2:
        return Summary(mean, 0.0, 0.0, runs, 0.0, 0.0)
    squared = divisor * divisor
    error, df = welch_satterthwaite([(part.squared_error / squared, part.df) for part in parts])
    deviation, groups = welch_satterthwaite([(part.variance / squared, part.groups) for part in parts])
    return Summary(mean, error * error, df, runs, deviation * deviation, groups)
