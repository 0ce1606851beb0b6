"""Intervals of means, of means over groups and of differences."""

from __future__ import annotations

import ast
import math
import random
from pathlib import Path

import pytest
from scipy import stats

from gym_extensions import scoring
from gym_extensions.scoring.statistics.intervals import (
    Interval,
    Summary,
    difference,
    interval,
    interval_from_error,
    mean_of_groups,
    rounded_quantile,
    subtract,
    summary,
    to_interval,
    welch_satterthwaite,
)


def samples(count: int) -> list[tuple[list[float], list[float]]]:
    rng = random.Random(7)
    return [
        (
            [rng.gauss(rng.uniform(-1, 1), rng.uniform(0.1, 2)) for _ in range(rng.randint(2, 9))],
            [rng.gauss(0, 1) for _ in range(rng.randint(2, 9))],
        )
        for _ in range(count)
    ]


def test_an_interval_by_hand() -> None:
    # s = 1, standard error 1/√3, t(.975, 2) = .95 √(2 / .0975).
    half_width = 0.95 * math.sqrt(2 / 0.0975) / math.sqrt(3)
    result = interval([1.0, 2.0, 3.0])
    assert (result.low, result.high) == pytest.approx((2 - half_width, 2 + half_width), rel=1e-11)
    assert result.standard_error == pytest.approx(1 / math.sqrt(3), rel=1e-15)
    assert result.df == 2


def test_a_single_run_has_no_interval() -> None:
    assert interval([0.5]) == Interval(0.5)
    assert difference([0.5], [0.25, 0.5]) == Interval(0.125)
    assert to_interval(mean_of_groups([summary([1.0]), summary([2.0, 4.0])])) == Interval(2.0)


def test_runs_without_variance_have_an_interval_without_width() -> None:
    assert interval([0.25] * 3) == Interval(0.25, 0.25, 0.25, 0.0, 2)
    assert difference([1.0, 1.0], [3.0, 3.0]) == Interval(-2.0, -2.0, -2.0, 0.0, 2.0)


def test_an_interval_agrees_with_scipy_stats() -> None:
    for values, _ in samples(50):
        result = interval(values)
        low, high = stats.t.interval(0.95, len(values) - 1, sum(values) / len(values), stats.sem(values))
        assert (result.low, result.high) == pytest.approx((low, high), rel=1e-10, abs=1e-10)


def test_the_interval_of_a_difference_agrees_with_scipy_stats_at_fractional_degrees_of_freedom() -> None:
    fractional = 0
    for first, second in samples(100):
        result = difference(first, second)
        expected = stats.ttest_ind(first, second, equal_var=False)
        low, high = expected.confidence_interval(0.95)
        assert result.df == pytest.approx(expected.df, rel=1e-10)
        assert (result.low, result.high) == pytest.approx((low, high), rel=1e-10, abs=1e-10)
        fractional += 1 < expected.df < 2.5 and expected.df % 1 > 0.01
    assert fractional >= 10


@pytest.mark.parametrize("df", [1, 1.2, 2, 4, 7.3, 200, 1e4])
def test_the_quantile_of_an_interval_has_12_significant_digits(df: float) -> None:
    value = rounded_quantile(df)
    assert len(repr(value).replace(".", "")) <= 12
    assert value == pytest.approx(float(stats.t.ppf(0.975, df)), rel=1e-11)


def test_no_quantile_of_up_to_200_runs_is_close_to_a_rounding_boundary() -> None:
    # The quantile of another build differs by some 1e-15; a boundary is more than 5e-15 away.
    for df in range(1, 200):
        exact = float(stats.t.ppf(0.975, df))
        assert {float(f"{exact * (1 + error):.12g}") for error in (-5e-15, 0, 5e-15)} == {
            rounded_quantile(df)
        }


@pytest.mark.parametrize("df", [0.0, 0.5, math.nan])
def test_fewer_than_one_degree_of_freedom_is_an_error(df: float) -> None:
    with pytest.raises(ValueError, match="at least 1 degree of freedom"):
        interval_from_error(0.0, 1.0, df)


def test_a_summary_by_hand() -> None:
    assert summary([1.0, 3.0, 5.0]) == Summary(3.0, 4 / 3, 2.0, 3, 4.0, 1.0)
    assert summary([2.0]) == Summary(2.0, 0.0, 0.0, 1, 0.0, 0.0)


def test_the_mean_of_groups_by_hand() -> None:
    # Squared errors 4/3 and 1/3 over 4: total 5/12; df = (5/12)² / ((1/3)²/2 + (1/12)²/2) = 50/17.
    result = mean_of_groups([summary([1.0, 3.0, 5.0]), summary([1.0, 2.0, 3.0])])
    assert (result.mean, result.runs) == (2.5, 3)
    assert (result.squared_error, result.df) == pytest.approx((5 / 12, 50 / 17), rel=1e-14)
    # With n runs per group: squared error 5/4 / n, and (n − 1) · 25/17 degrees of freedom.
    assert (result.variance, result.groups) == pytest.approx((5 / 4, 25 / 17), rel=1e-14)


def test_a_difference_of_summaries_is_the_difference_of_their_runs() -> None:
    for first, second in samples(20):
        assert to_interval(subtract(summary(first), summary(second))) == difference(first, second)


def test_welch_satterthwaite_by_hand() -> None:
    assert welch_satterthwaite([(1.0, 4.0), (3.0, 2.0)]) == (2.0, 16 / (1 / 4 + 9 / 2))
    assert welch_satterthwaite([(1.0, 4.0), (0.0, 2.0)]) == (1.0, 4.0)
    assert welch_satterthwaite([(0.0, 4.0), (0.0, 2.0)]) == (0.0, 6.0)


def test_degrees_of_freedom_are_at_least_the_smallest_where_squares_underflow() -> None:
    # The square of 3.85e-162 is three times the smallest positive number, a quarter of it rounds to one.
    assert welch_satterthwaite([(3.85e-162, 4.0), (0.0, 9.0)])[1] == 4.0


def test_no_power_operator_on_scored_numbers() -> None:
    # ** of floats is the C library's pow, whose last bit depends on the machine; a product is exact.
    powers = [
        f"{path.name}:{node.lineno}"
        for path in sorted(Path(str(scoring.__file__)).parent.rglob("*.py"))
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow)
        if isinstance(node.right, ast.Constant) and not isinstance(node.left, ast.Constant)
    ]
    assert powers == []
