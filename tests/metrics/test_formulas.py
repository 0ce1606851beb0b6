"""Formulas that the conformance kit has no case of."""

import numpy as np
import pytest
from scipy import stats

from gym_extensions.metrics.formulas import BY_NAME, NormalizedRun, probability_of_improvement


def test_the_probability_of_improvement_is_that_of_mann_whitney() -> None:
    assert probability_of_improvement([[1, 5], [2, 5]], [[1, 9]]) == (0.75 + 0) / 2
    rng = np.random.default_rng(5)
    first, second = rng.integers(0, 9, (7, 3)), rng.integers(0, 9, (5, 3))
    u = stats.mannwhitneyu(first, second, axis=0).statistic
    assert probability_of_improvement(first, second) == pytest.approx(np.mean(u / (7 * 5)), abs=1e-12)


@pytest.mark.parametrize(("episodes", "expected"), [(1, 0.0), (10, 0.0), (11, 0.5), (20, 0.5), (21, 1.0)])
def test_cvar_is_the_mean_of_the_lowest_tenth_rounded_up(episodes: int, expected: float) -> None:
    # Of the returns 0, 1, 2, … the lowest tenth is 0, from 11 episodes 0 and 1, from 21 episodes 0 to 2.
    run = NormalizedRun(1, (1,), {}, final_episodes={1: tuple(map(float, reversed(range(episodes))))})
    assert BY_NAME["cvar_10"].of_run(run) == expected
