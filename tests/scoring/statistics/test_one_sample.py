"""The one-sample t test agrees with scipy.stats."""

from __future__ import annotations

import pytest
from scipy import stats

from gym_extensions.scoring.statistics.intervals import summary
from gym_extensions.scoring.statistics.one_sample import zero_mean_p


@pytest.mark.parametrize("values", [[0.1, 0.4, 0.2], [-3.0, 1.0], [1e-9, 2e-9, -4e-9, 1e-9], [5.0, 6.0, 5.5]])
def test_the_p_value_is_that_of_scipy(values: list[float]) -> None:
    assert zero_mean_p(summary(values)) == pytest.approx(stats.ttest_1samp(values, 0.0).pvalue, rel=1e-12)


@pytest.mark.parametrize(("values", "p_value"), [([0.0, 0.0], 1.0), ([2.0, 2.0], 0.0), ([-1.0, 1.0], 1.0)])
def test_without_variance_a_mean_is_zero_or_it_is_not(values: list[float], p_value: float) -> None:
    assert zero_mean_p(summary(values)) == p_value
