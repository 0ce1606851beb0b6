"""The formulas against the same definitions written as plain loops."""

import random
from collections.abc import Callable

import numpy as np
import pytest
from scipy import stats

from gym_extensions.metrics.formulas import (
    BY_NAME,
    NormalizedRun,
    iqm,
    probability_of_improvement,
)
from gym_extensions.metrics.statistics import Number

Matrix = list[list[float]]


def function(name: str) -> Callable[[NormalizedRun], Number]:
    """The formula of a metric."""
    formula = BY_NAME[name].of_run
    assert formula is not None
    return formula


def run_of(matrix: Matrix, single: list[float] | None = None) -> NormalizedRun:
    """A run whose p[s][j] is ``matrix[s][j - 1]``."""
    T = len(matrix[0])
    cells = {(s, j): matrix[s][j - 1] for s in range(T + 1) for j in range(1, T + 1)}
    return NormalizedRun(T, tuple(range(1, T + 1)), cells, single_task=dict(enumerate(single or [], 1)))


def matrices(count: int = 30) -> list[Matrix]:
    rng = random.Random(2)
    sizes = [rng.randint(2, 8) for _ in range(count)]
    return [[[rng.uniform(-1, 2) for _ in range(T)] for _ in range(T + 1)] for T in sizes]


def backward_transfer(R: Matrix) -> float:
    """Lopez-Paz & Ranzato 2017, equation 3: 1/(T−1) Σ_{i<T} R[T][i] − R[i][i]."""
    T = len(R[0])
    total = 0.0
    for i in range(1, T):
        total += R[T][i - 1] - R[i][i - 1]
    return total / (T - 1)


def zero_shot(R: Matrix) -> float:
    """Lopez-Paz & Ranzato 2017, equation 4: 1/(T−1) Σ_{i≥2} R[i−1][i] − b_i, b the untrained policy's."""
    T = len(R[0])
    total = 0.0
    for i in range(2, T + 1):
        total += R[i - 1][i - 1] - R[0][i - 1]
    return total / (T - 1)


def worst_forgetting(R: Matrix) -> float:
    """Chaudhry et al. 2018, equation 3, at k = T: each earlier task's best so far, less what is left."""
    T = len(R[0])
    drops = []
    for j in range(1, T):
        best = -float("inf")
        for stage in range(j, T):
            best = max(best, R[stage][j - 1])
        drops.append(best - R[T][j - 1])
    return sum(drops) / (T - 1)


def later_forgetting(R: Matrix) -> float:
    """LIBERO (Liu et al. 2023), NBT: the mean drop at all later stages, here over the T − 1 earlier tasks."""
    T = len(R[0])
    means = []
    for j in range(1, T):
        drops = [R[j][j - 1] - R[stage][j - 1] for stage in range(j + 1, T + 1)]
        means.append(sum(drops) / len(drops))
    return sum(means) / (T - 1)


def average(R: Matrix) -> float:
    """Díaz-Rodríguez et al. 2018: the mean of the lower triangle with its diagonal."""
    T = len(R[0])
    cells = []
    for i in range(1, T + 1):
        for j in range(1, i + 1):
            cells.append(R[i][j - 1])
    return sum(cells) / (T * (T + 1) / 2)


PLAIN: dict[str, Callable[[Matrix], float]] = {
    "forgetting": lambda R: -backward_transfer(R),
    "zero_shot_transfer": zero_shot,
    "worst_case_forgetting": worst_forgetting,
    "mean_later_forgetting": later_forgetting,
    "average_lower_triangle": average,
}


@pytest.mark.parametrize("name", PLAIN)
def test_formulas_are_those_of_the_papers_that_they_name(name: str) -> None:
    for matrix in matrices():
        assert function(name)(run_of(matrix)) == pytest.approx(PLAIN[name](matrix), abs=1e-12)


def test_the_interquartile_mean_is_scipys_trimmed_mean() -> None:
    rng = random.Random(4)
    for count in range(1, 40):
        values = [rng.gauss(0, 1) for _ in range(count)]
        assert iqm([values]) == pytest.approx(stats.trim_mean(values, 0.25), abs=1e-12)


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
    assert function("cvar_10")(run) == expected
