"""Quantiles, tests and powers against scipy, which knows them and which scoring does not use."""

from __future__ import annotations

import math
import random

import pytest
from scipy import stats

from gym_extensions.scoring.intervals import difference, interval, quantile, summary
from gym_extensions.scoring.quantiles import T_975
from gym_extensions.scoring.ranks import (
    different,
    holm,
    rank_intervals,
    runs_to_separate,
    welch_p,
    welch_t,
)
from gym_extensions.scoring.student import critical, power, two_sided_p


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
        t, freedom = welch_t(summary(first), summary(second))
        assert t == pytest.approx(expected.statistic, rel=1e-9)
        assert freedom == pytest.approx(expected.df, rel=1e-9)
        assert two_sided_p(t, freedom) == pytest.approx(expected.pvalue, rel=1e-9)


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


def test_holms_procedure_by_hand() -> None:
    # .01 ≤ .05/4, .013 ≤ .05/3, .03 > .05/2: it stops there, although .04 ≤ .05.
    assert holm([0.03, 0.01, 0.04, 0.013]) == [False, True, False, True]
    assert holm([0.05]) == [True]
    assert holm([0.051]) == [False]
    assert holm([]) == []


def _adjusted(values: list[float]) -> list[float]:
    """Holm's adjusted p values, written down from their definition."""
    order = sorted(values)
    return [
        max(min(1.0, (len(values) - place) * one) for place, one in enumerate(order) if one <= value)
        for value in values
    ]


def test_holms_procedure_rejects_where_the_adjusted_p_value_is_at_most_the_level() -> None:
    rng = random.Random(3)
    for _ in range(200):
        values = [rng.random() ** 4 for _ in range(rng.randint(1, 12))]
        assert holm(values) == [adjusted <= 0.05 for adjusted in _adjusted(values)]


def test_a_small_t_is_not_looked_up_and_would_not_be_significant() -> None:
    assert two_sided_p(1.9, 1e6) > 0.05
    assert welch_p(summary([0, 1, 2]), summary([0.1, 1.1, 2.1])) == 1.0


def test_entries_without_variance_differ_if_their_means_do() -> None:
    entries = [summary([1.0] * 5), summary([1.0] * 5), summary([2.0] * 5)]
    assert different(entries) == {(0, 2), (1, 2)}
    assert welch_t(entries[0], entries[2])[0] == -math.inf


def test_ranks_do_not_depend_on_the_order_of_entries() -> None:
    rng = random.Random(5)
    entries = [summary([rng.gauss(place, 1) for _ in range(5)]) for place in range(8)]
    ranks = rank_intervals(entries, different(entries), "higher")
    turned = rank_intervals(entries[::-1], different(entries[::-1]), "higher")
    assert turned == ranks[::-1]


@pytest.mark.parametrize(("runs", "gap"), [(5, 4.5), (10, 2.25)])
def test_five_runs_separate_four_and_a_half_deviations_on_a_board_of_ten(runs: int, gap: float) -> None:
    assert runs_to_separate(gap, 1.0, 1.0, 10) == runs


def test_runs_to_separate_in_dumb_cases() -> None:
    assert runs_to_separate(0.0, 1.0, 1.0, 2) is None
    assert runs_to_separate(0.01, 1.0, 1.0, 2) is None
    assert runs_to_separate(1.0, 0.0, 0.0, 2) == 2
    assert runs_to_separate(1.0, 1.0, 1.0, 2) == 17  # as any table of sample sizes has it: d = 1, 80 %, 5 %


def test_runs_to_separate_has_the_power_that_it_names() -> None:
    rng = random.Random(11)
    runs = runs_to_separate(2.0, 1.0, 0.5, 2)
    assert runs is not None
    seen = sum(
        welch_p(
            summary([rng.gauss(2, 1) for _ in range(runs)]), summary([rng.gauss(0, 0.5) for _ in range(runs)])
        )
        <= 0.05
        for _ in range(2000)
    )
    assert seen / 2000 >= 0.78
    fewer = runs - 1
    limit = critical(0.05, (fewer - 1) * 1.25**2 / (1 + 0.0625))
    assert power(2 / math.sqrt(1.25 / fewer), limit, (fewer - 1) * 1.25**2 / (1 + 0.0625)) < 0.8
