"""Statistics over runs: means, Student's t, intervals, Welch's test with Holm's correction, ranks.

The distribution functions are those of ``scipy.special``, which ``scipy.stats`` calls: to import
``scipy.stats`` takes .7 s more. Degrees of freedom (``df``) are any number of at least 1, integer or not.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from scipy.special import fdtr, stdtr, stdtrit

from gym_extensions.errors import BenchError

Number = float | None
Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
ALPHA = 0.05
"""Family-wise error rate of a metric of a board."""


def mean(values: Iterable[float]) -> Number:
    """The mean by ``math.fsum``, or None for an empty input. It is never 0 instead."""
    numbers = list(values)
    return math.fsum(numbers) / len(numbers) if numbers else None


def standard_deviation(values: Sequence[float], ddof: int = 0) -> float:
    """The standard deviation with divisor n − ``ddof``, as in ``numpy.std``."""
    center = math.fsum(values) / len(values)
    residuals = [value - center for value in values]
    return math.sqrt(math.fsum([r * r for r in residuals]) / (len(values) - ddof))


def _rounded(value: float) -> float:
    """A value of a distribution function, rounded to 12 significant digits.

    A library's last bits depend on the processor and the build. Everything else in an interval
    (``math.fsum``, products, quotients, square roots) is exact or correctly rounded by IEEE 754, so with
    rounded quantiles the ends of an interval have the same bits on every machine.
    """
    return float(f"{value:.12g}")


@lru_cache(maxsize=1024)
def critical_value(alpha: float, df: float) -> float:
    """The t with a two-sided p value of ``alpha``, precise for the smallest ``alpha``, too; 12 digits."""
    return -_rounded(stdtrit(df, alpha / 2))


@dataclass(frozen=True)
class Interval:
    """A mean with its 95 % confidence interval, its standard error and the degrees of freedom of that.

    All but the mean are None if a single run leaves the interval undefined.
    """

    mean: float
    low: float | None = None
    high: float | None = None
    standard_error: float | None = None
    df: float | None = None


@dataclass(frozen=True)
class Summary:
    """A mean over runs with its squared standard error, and the degrees of freedom of that.

    Both are 0 with one run. ``runs`` is the number of runs, the smallest one for a combination of means.
    """

    mean: float
    squared_error: float
    df: float
    runs: int


def summary(values: Sequence[float]) -> Summary:
    """The summary of one value per run.

    Raises ``BenchError`` for no value (``no-values``) and for a value that is not a finite number
    (``bad-values``).
    """
    try:
        total, runs = math.fsum(values), len(values)
    except (TypeError, ValueError, OverflowError):
        total, runs = math.nan, 1
    if not runs:
        raise BenchError("no-values", "There are no values.", "values", "Give one value per run.")
    if not math.isfinite(total):
        raise BenchError("bad-values", f"They are {values!r}.", "values", "Give one finite number per run.")
    mean = total / runs
    if runs < 2:
        return Summary(mean, 0.0, 0.0, runs)
    deviation = standard_deviation(values, ddof=1)
    return Summary(mean, deviation * deviation / runs, runs - 1.0, runs)


def mean_of_groups(groups: Sequence[Summary]) -> Summary:
    """The summary of the mean over independent groups, with SE² = Σ SE_g² / G² and Welch–Satterthwaite df."""
    count = len(groups)
    return _combine(math.fsum(group.mean for group in groups) / count, groups, count)


def ratio_of_groups(groups: Sequence[tuple[Sequence[float], Sequence[float]]]) -> Interval:
    """The mean over groups of a first value, divided by that of a second one, both known for every run.

    The interval is that of the linearized ratio r: the standard error of the mean of (first − r · second),
    divided by the mean of the second, which is not 0 (Cochran 1977, "Sampling Techniques", section 6.4).
    """
    first, second = (mean_of_groups([summary(pair[at]) for pair in groups]).mean for at in (0, 1))
    ratio = first / second
    residuals = [[(a - ratio * b) / second for a, b in zip(*pair, strict=True)] for pair in groups]
    spread = mean_of_groups(list(map(summary, residuals)))
    return to_interval(replace(spread, mean=ratio))


def iqm_shares(groups: Sequence[Array]) -> list[list[float]]:
    """A value per run whose mean over runs, then over groups, is the interquartile mean of all scores.

    They are the scores, with those outside of the middle half moved to its ends, scaled and shifted: the
    influence of each run (Huber & Ronchetti 2009, "Robust Statistics", section 3.3). So their spread gives
    the standard error of the interquartile mean, and it is compared as a mean over groups is.

    Args:
        groups: the scores of each group, (runs, tasks).
    """
    ordered = np.sort(np.concatenate([scores.ravel() for scores in groups]))
    cut = ordered.size // 4
    low, high, kept = ordered[cut], ordered[-cut - 1], ordered.size - 2 * cut
    scales = [len(groups) * len(scores) / kept for scores in groups]
    shift = cut * (low + high) / kept
    sums = [np.clip(scores, low, high).sum(axis=1) for scores in groups]
    return [(scale * each - shift).tolist() for scale, each in zip(scales, sums, strict=True)]


def subtract(first: Summary, second: Summary) -> Summary:
    """The summary of first − second, unpaired."""
    return _combine(first.mean - second.mean, (first, second), 1)


def _combine(mean: float, parts: Sequence[Summary], divisor: int) -> Summary:
    runs = min(part.runs for part in parts)
    if runs < 2:
        return Summary(mean, 0.0, 0.0, runs)
    squared = divisor * divisor
    error, df = welch_satterthwaite([(part.squared_error / squared, part.df) for part in parts])
    return Summary(mean, error * error, df, runs)


def welch_satterthwaite(terms: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """Standard error and df of a sum of means, from the squared standard error and df of each."""
    total = math.fsum(square for square, _ in terms)
    denominator = math.fsum(square * square / df for square, df in terms)
    if denominator == 0:
        return math.sqrt(total), math.fsum(df for _, df in terms)
    return math.sqrt(total), max(total * total / denominator, min(df for _, df in terms))


def to_interval(estimate: Summary, expert_errors: Iterable[tuple[float, float]] = ()) -> Interval:
    """mean ± t(.975, df) · standard error. A single run has no interval.

    An absolute score, but no difference between submissions, also has the errors of its tasks' experts.
    All are independent; the degrees of freedom are those of Welch and Satterthwaite.

    Args:
        estimate: the score over runs.
        expert_errors: of every task, the squared standard error that its expert adds, and its df.
    """
    if estimate.runs < 2:
        return Interval(estimate.mean)
    error, df = math.sqrt(estimate.squared_error), estimate.df
    if terms := [(square, df) for square, df in expert_errors if square > 0]:
        error, df = welch_satterthwaite([(estimate.squared_error, estimate.df), *terms])
    half_width = critical_value(0.05, df) * error
    return Interval(estimate.mean, estimate.mean - half_width, estimate.mean + half_width, error, df)


def interval(values: Sequence[float]) -> Interval:
    """The mean of one value per run, ± t(.975, N − 1) · s / √N. A single run has no interval."""
    return to_interval(summary(values))


def difference(first: Sequence[float], second: Sequence[float]) -> Interval:
    """Welch's unpaired interval of mean(first) − mean(second). There is none if either has a single run."""
    return to_interval(subtract(summary(first), summary(second)))


def zero_mean_p(estimate: Summary) -> float:
    """The two-sided p value of a mean of zero. Without variance it is 1 for a mean of zero and 0 for another.

    Of a difference (:func:`subtract`) it is Welch's test; the differences of paired runs give the paired t
    test. It needs two runs.
    """
    if estimate.mean == 0 or estimate.squared_error == 0:
        return float(estimate.mean == 0)
    return _rounded(2 * stdtr(estimate.df, -abs(estimate.mean) / math.sqrt(estimate.squared_error)))


def smaller_spread_p(
    values: Sequence[float], others: Sequence[Sequence[float]], share: float
) -> tuple[float, float]:
    """The one-sided p value of a standard deviation not below ``share`` of the others', and that of those.

    It is that of an F test against the pooled variance of the others. Each has at least two values.
    """
    df = sum(len(each) - 1 for each in others)
    squares = (standard_deviation(each, ddof=1) ** 2 * (len(each) - 1) for each in others)
    variance, own = math.fsum(squares) / df, standard_deviation(values, ddof=1) ** 2
    p_value = float(fdtr(len(values) - 1, df, own / (share * share * variance))) if variance else 1.0
    return p_value, math.sqrt(variance)


def holm(p_values: Array) -> Mask:
    """Which hypotheses Holm's step-down procedure rejects at the family-wise error rate ``ALPHA``."""
    return holm_adjusted(p_values) <= ALPHA


def holm_adjusted(p_values: Array) -> Array:
    """The adjusted p values: the lowest family-wise error rate at which Holm's procedure rejects each."""
    order = np.argsort(p_values)
    adjusted = np.empty_like(p_values, dtype=np.float64)
    steps = np.maximum.accumulate(p_values[order] * np.arange(p_values.size, 0, -1))
    adjusted[order] = np.minimum(steps, 1.0)
    return adjusted


def significant_pairs(submissions: Sequence[Summary]) -> Mask:
    """A symmetric M × M matrix, True where Welch's test with Holm's correction separates two submissions."""
    matrix = np.zeros((len(submissions), len(submissions)), dtype=np.bool_)
    p_values = [zero_mean_p(subtract(*pair)) for pair in combinations(submissions, 2)]
    matrix[np.triu_indices(len(submissions), 1)] = holm(np.array(p_values))
    return matrix | matrix.T


def rank_intervals(submissions: Sequence[Summary], significant: Mask, better: str) -> list[tuple[int, int]]:
    """The first and last possible rank of each submission, from the matrix of :func:`significant_pairs`.

    They are 1 + (number of significantly better submissions) and M − (number of significantly worse
    submissions). With 95 % confidence, all of them hold for normal runs (Mogstad, Romano, Shaikh & Wilhelm
    2024).
    """
    mean = np.array([submission.mean for submission in submissions])
    loses = mean[:, None] < mean if better == "higher" else mean[:, None] > mean
    losses = (significant & loses).sum(axis=1).tolist()
    wins = (significant & loses.T).sum(axis=1).tolist()
    return [(1 + above, len(submissions) - below) for above, below in zip(losses, wins, strict=True)]
