"""Quantiles, tests and powers against scipy, which knows them and which scoring does not use."""

from __future__ import annotations

import ast
import random
from pathlib import Path

import pytest
from scipy import stats

from gym_extensions import scoring
from gym_extensions.scoring.statistics.intervals import difference, interval, quantile, summary
from gym_extensions.scoring.statistics.quantiles import T_975
from gym_extensions.scoring.statistics.student_t import critical, power
from gym_extensions.scoring.statistics.welch import HOPELESS, pairs


def test_the_table_of_quantiles_is_students() -> None:
    assert len(T_975) == 200
    for freedom, value in enumerate(T_975, 1):
        assert value == pytest.approx(stats.t.ppf(0.975, freedom), rel=1e-11)


@pytest.mark.parametrize("freedom", [1.2, 1.5, 2.5, 3.7, 4.1, 7.3, 11.9, 47.5])
def test_between_whole_degrees_of_freedom_the_quantile_errs_to_the_wide_side(freedom: float) -> None:
    exact = stats.t.ppf(0.975, freedom)
    slack = 0.2 if freedom < 2 else 0.04 if freedom < 4 else 0.002
    assert exact <= quantile(freedom) <= exact * (1 + slack)


def test_beyond_the_table_the_last_quantile_is_kept() -> None:
    assert quantile(10_000) == T_975[-1]
    assert quantile(10_000) == pytest.approx(stats.norm.ppf(0.975), rel=0.007)


def test_less_than_one_degree_of_freedom_is_our_own_mistake() -> None:
    with pytest.raises(ValueError, match="degrees of freedom"):
        quantile(0.5)


def _samples(count: int) -> list[tuple[list[float], list[float]]]:
    rng = random.Random(7)
    return [
        (
            [rng.gauss(rng.uniform(-1, 1), rng.uniform(0.1, 2)) for _ in range(rng.randint(2, 9))],
            [rng.gauss(0, 1) for _ in range(rng.randint(2, 9))],
        )
        for _ in range(count)
    ]


def test_an_interval_is_students_t_over_runs() -> None:
    for first, _ in _samples(50):
        found = interval(first)
        low, high = stats.t.interval(0.95, len(first) - 1, sum(first) / len(first), stats.sem(first))
        assert (found.low, found.high) == pytest.approx((low, high), rel=1e-9)


def test_welchs_test_is_scipys() -> None:
    for first, second in _samples(200):
        expected = stats.ttest_ind(first, second, equal_var=False)
        found = pairs([summary(first), summary(second)])
        t, freedom = found.welch(0, 1)
        assert float(t) == pytest.approx(expected.statistic, rel=1e-9)
        assert float(freedom) == pytest.approx(expected.df, rel=1e-9)
        assert found.exact(0, 1) == (pytest.approx(expected.pvalue, rel=1e-9) if abs(t) > HOPELESS else 1)


def test_the_interval_of_a_difference_is_welchs() -> None:
    for first, second in _samples(100):
        found = difference(first, second)
        expected = stats.ttest_ind(first, second, equal_var=False).confidence_interval(0.95)
        assert found.low is not None
        assert found.high is not None
        width = expected.high - expected.low
        assert found.low <= expected.low + 1e-9 * width
        assert expected.high - 1e-9 * width <= found.high
        assert found.high - found.low <= width * 1.2


@pytest.mark.parametrize("freedom", [1.0, 2.5, 4.0, 8.0, 30.0, 200.0])
@pytest.mark.parametrize("level", [0.05, 0.01, 0.05 / 45, 0.05 / 1225])
def test_critical_values_are_students(freedom: float, level: float) -> None:
    assert critical(level, freedom) == pytest.approx(stats.t.isf(level / 2, freedom), rel=1e-9)


@pytest.mark.parametrize("freedom", [2.0, 4.0, 8.0, 18.0, 100.0])
@pytest.mark.parametrize("shift", [0.0, 1.0, 3.0, 6.0])
def test_power_is_the_noncentral_ts(freedom: float, shift: float) -> None:
    limit = critical(0.05, freedom)
    exact = stats.nct.sf(limit, freedom, shift) + stats.nct.cdf(-limit, freedom, shift)
    assert power(shift, limit, freedom) == pytest.approx(exact, abs=1e-6)


def test_nothing_that_is_scored_is_squared_by_the_c_librarys_pow() -> None:
    # ** of floats is pow, whose last bit differs from machine to machine; a product and a root are exact.
    powers = [
        f"{path.name}:{node.lineno}"
        for path in sorted(Path(str(scoring.__file__)).parent.rglob("*.py"))
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow)
        if isinstance(node.right, ast.Constant) and not isinstance(node.left, ast.Constant)
    ]
    assert powers == []
