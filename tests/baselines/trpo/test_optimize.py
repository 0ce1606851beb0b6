"""Conjugate gradient and the line search against dense algebra and by hand."""

from __future__ import annotations

import numpy as np
import pytest

from gym_extensions.baselines.trpo.update import conjugate_gradient, line_search


@pytest.mark.parametrize("size", [1, 2, 5, 20])
def test_conjugate_gradient_solves_a_positive_definite_system(size: int) -> None:
    rng = np.random.default_rng(size)
    root = rng.standard_normal((size, size))
    matrix = root @ root.T + np.eye(size)
    target = rng.standard_normal(size)
    solution = conjugate_gradient(
        lambda vector: matrix @ vector, target, iterations=3 * size, tolerance=1e-24
    )
    np.testing.assert_allclose(solution, np.linalg.solve(matrix, target), rtol=1e-7, atol=1e-9)


def test_conjugate_gradient_returns_zero_for_a_zero_target() -> None:
    assert not conjugate_gradient(lambda vector: 2 * vector, np.zeros(4)).any()


def test_one_iteration_of_conjugate_gradient_is_the_steepest_descent_step_by_hand() -> None:
    # A = diag(1, 3), b = (1, 1): bᵀb / bᵀAb = 2 / 4.
    solution = conjugate_gradient(lambda vector: np.array([1.0, 3.0]) * vector, np.ones(2), iterations=1)
    np.testing.assert_allclose(solution, [0.5, 0.5])


def test_the_line_search_takes_the_first_accepted_step() -> None:
    point, tries = line_search(lambda at: bool(at[0] <= 0.7), np.zeros(1), np.ones(1), shrink=0.8)
    assert (tries, point[0]) == (2, pytest.approx(0.64))


def test_the_line_search_returns_the_start_if_no_step_is_accepted() -> None:
    start = np.array([3.0])
    point, tries = line_search(lambda at: False, start, np.ones(1), tries=4)
    assert tries == 4
    assert point is start
