"""Mean and standard deviation."""

from __future__ import annotations

import random

import numpy as np
import pytest

from gym_extensions.scoring.statistics.descriptive import mean, standard_deviation


def test_the_mean_of_an_empty_input_is_none() -> None:
    assert mean([]) is None
    assert mean(iter([1.0, 2.0, 6.0])) == 3.0


def test_the_mean_is_summed_exactly() -> None:
    assert sum([0.1] * 10) != 1.0
    assert mean([0.1] * 10) == 0.1
    assert mean([1e16, 1.0, -1e16, 1.0]) == 0.5


def test_the_standard_deviation_by_hand() -> None:
    # Residuals -2, 0, 2: 8/3 for a population, 8/2 for a sample.
    assert standard_deviation([1.0, 3.0, 5.0]) == pytest.approx((8 / 3) ** 0.5, rel=1e-15)
    assert standard_deviation([1.0, 3.0, 5.0], ddof=1) == 2.0
    assert standard_deviation([4.0]) == 0.0


@pytest.mark.parametrize("ddof", [0, 1])
def test_the_standard_deviation_is_numpys(ddof: int) -> None:
    rng = random.Random(4)
    for count in (2, 3, 20):
        values = [rng.gauss(1000, 1) for _ in range(count)]
        expected = pytest.approx(np.std(values, ddof=ddof), rel=1e-12)
        assert standard_deviation(values, ddof) == expected
        assert standard_deviation(values, ddof, center=sum(values) / count) == expected
