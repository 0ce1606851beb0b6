"""Student's t distribution: closed forms, and agreement with ``scipy.stats``."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from gym_extensions.scoring.statistics.student_t import critical_value, power, quantile, two_sided_p

DF = [1.0, 1.2, 1.5, 2.0, 2.5, 4.0, 8.0, 30.0, 200.0, 1e4]


@pytest.mark.parametrize("probability", [0.6, 0.9, 0.975, 0.999])
def test_quantiles_of_one_and_two_degrees_of_freedom_have_closed_forms(probability: float) -> None:
    assert quantile(probability, 1) == pytest.approx(math.tan(math.pi * (probability - 0.5)), rel=1e-12)
    tails = 4 * probability * (1 - probability)
    assert quantile(probability, 2) == pytest.approx((2 * probability - 1) * math.sqrt(2 / tails), rel=1e-12)


@pytest.mark.parametrize("df", DF)
def test_quantiles_agree_with_scipy_stats(df: float) -> None:
    for probability in (0.025, 0.5, 0.8, 0.975, 0.99999):
        expected = float(stats.t.ppf(probability, df))
        assert quantile(probability, df) == pytest.approx(expected, rel=1e-12, abs=1e-12)


def test_p_values_of_one_degree_of_freedom_by_hand() -> None:
    # Cauchy: P(|T| ≥ t) = 1 − 2 arctan(t) / π.
    t = np.array([0.0, 1.0, -1.0, math.sqrt(3), math.inf, -math.inf])
    assert two_sided_p(t, 1.0).tolist() == pytest.approx([1, 1 / 2, 1 / 2, 1 / 3, 0, 0], rel=1e-14)


@pytest.mark.parametrize("df", DF)
def test_p_values_agree_with_scipy_stats_far_into_the_tail(df: float) -> None:
    t = np.array([0.0, 0.1, 1.9, 5.0, 30.0, 1000.0])
    assert two_sided_p(t, df) == pytest.approx(2 * stats.t.sf(t, df), rel=1e-12, abs=1e-250)


@pytest.mark.parametrize("df", DF)
@pytest.mark.parametrize("alpha", [0.05, 0.05 / 45, 0.05 / 499_500])
def test_the_p_value_of_a_critical_value_is_alpha(alpha: float, df: float) -> None:
    assert float(two_sided_p(critical_value(alpha, df), df)) == pytest.approx(alpha, rel=1e-12)


@pytest.mark.parametrize("df", [4.0, 8.0, 18.5, 100.0, 1980.0])
@pytest.mark.parametrize("shift", [0.0, 1.0, 3.0, 6.0])
def test_power_is_the_tail_of_the_noncentral_t(df: float, shift: float) -> None:
    critical = critical_value(0.05, df)
    assert power(shift, critical, df) == pytest.approx(float(stats.nct.sf(critical, df, shift)), abs=1e-9)


def test_power_without_a_difference_is_half_of_alpha() -> None:
    assert power(0.0, critical_value(0.05, 8), 8) == pytest.approx(0.025, rel=1e-9)


@pytest.mark.parametrize("df", [4.0, 8.5, 20.0, 990.0])
@pytest.mark.parametrize("alpha", [0.05, 0.05 / 499_500])
def test_power_never_decreases_and_is_a_number_for_any_shift(alpha: float, df: float) -> None:
    critical = critical_value(alpha, df)
    shifts = [0.0, 1.0, 2.8, 5.0, 10.0, 38.0, 40.0, 1e3, 1e6, 1e150, math.inf]
    powers = [power(shift, critical, df) for shift in shifts]
    assert powers == sorted(powers)
    assert 0.95 < powers[-1] <= 1
