"""The quadratic penalty, and what l2, l2-init and online EWC anchor."""

from __future__ import annotations

import numpy as np
import pytest

from gym_extensions.baselines.algorithms.continual import Quadratic
from gym_extensions.baselines.algorithms.l2 import InitialWeights, PreviousTask
from gym_extensions.baselines.algorithms.online_ewc import OnlineEwc, diagonal_fisher
from gym_extensions.baselines.trpo.policy import Architecture, log_density, mean_and_log_sigma

from ...trpo.policies import ARCHITECTURES, numeric_gradient, random_policy

PENALTY = Quadratic(0.5, np.array([2.0, 0.0, 1.0]), np.array([1.0, 1.0, -1.0]))
THETA = np.array([2.0, 7.0, 1.0])
LINE = Architecture((1, 1))
"""Mean w x + b; the parameters are w, b and log σ."""


def test_a_penalty_by_hand() -> None:
    # .5 / 2 · (2 · 1² + 0 · 6² + 1 · 2²) and .5 · (2 · 1, 0 · 6, 1 · 2).
    assert PENALTY.value(THETA) == 1.5
    np.testing.assert_allclose(PENALTY.gradient(THETA), [1, 0, 1])


def test_gradient_and_curvature_are_the_derivatives() -> None:
    np.testing.assert_allclose(
        PENALTY.gradient(THETA), numeric_gradient(PENALTY.value, THETA), rtol=1e-6, atol=1e-9
    )
    curvature, vector = PENALTY.curvature(THETA), np.array([1.0, -2.0, 0.5])
    difference = (PENALTY.gradient(THETA + 1e-4 * vector) - PENALTY.gradient(THETA)) / 1e-4
    np.testing.assert_allclose(curvature.product(vector), difference, rtol=1e-8)
    np.testing.assert_allclose(curvature.diagonal, [1, 0, 0.5])


def test_l2_pulls_to_the_parameters_after_the_previous_task_and_not_before() -> None:
    regularizer = PreviousTask(2.0)
    regularizer.start(np.zeros(3))
    assert regularizer.penalty(LINE, np.asarray) is None
    for last in (np.ones(3), np.full(3, 5.0)):
        regularizer.end_of_task(LINE, last, np.zeros((0, 1)), np.asarray)
        penalty = regularizer.penalty(LINE, np.asarray)
        assert penalty is not None
        assert penalty.value(last + np.array([1, 0, 2])) == 5.0


def test_l2_init_pulls_to_the_initial_parameters_in_every_task() -> None:
    regularizer = InitialWeights(2.0)
    regularizer.start(np.zeros(3))
    regularizer.end_of_task(LINE, np.ones(3), np.zeros((0, 1)), np.asarray)
    penalty = regularizer.penalty(LINE, np.asarray)
    assert penalty is not None
    assert penalty.value(np.array([1.0, 0, 2])) == 5.0


def test_the_diagonal_of_the_fisher_matrix_by_hand() -> None:
    # ∂μ/∂w = x, ∂μ/∂b = 1; σ = 2, so w: mean(1, 9) / 4, b: 1 / 4, log σ: 2.
    fisher = diagonal_fisher(LINE, np.array([0.3, 0.1, np.log(2)]), np.array([[1.0], [3.0]]))
    np.testing.assert_allclose(fisher, [1.25, 0.25, 2])


@pytest.mark.parametrize("architecture", ARCHITECTURES, ids=["linear", "tanh"])
def test_the_diagonal_is_the_mean_squared_gradient_of_the_log_density(architecture: Architecture) -> None:
    rng, theta = np.random.default_rng(3), random_policy(architecture)
    theta[-2:] = [-0.5, 0.2]
    state = rng.standard_normal((1, 3))
    exact = diagonal_fisher(architecture, theta, state)
    mean, log_sigma = mean_and_log_sigma(architecture, theta, state)
    # μ ± σ in each component has the mean, variance and squares of the Gaussian: exact for the means' part.
    squares = []
    for signs in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
        action = mean + np.exp(log_sigma) * np.array(signs)

        def density(at: np.ndarray, action: np.ndarray = action) -> float:
            return float(log_density(*mean_and_log_sigma(architecture, at, state), action)[0])

        squares.append(numeric_gradient(density, theta) ** 2)
    np.testing.assert_allclose(exact[:-2], np.mean(squares, axis=0)[:-2], rtol=1e-5, atol=1e-8)


def test_online_ewc_adds_the_normalized_importance_of_each_task_and_decays_the_sum() -> None:
    regularizer, sigma_2 = OnlineEwc(4.0, 0.5, 2), np.log(2)
    regularizer.end_of_task(LINE, np.array([0, 0, sigma_2]), np.array([[1.0], [3.0]]), np.asarray)
    # Fisher (1.25, .25, 2), mean 7/6; the importance is .5 times Fisher / mean.
    first = 0.5 * np.array([1.25, 0.25, 2]) * 6 / 7
    np.testing.assert_allclose(regularizer.state["importance"], first)
    regularizer.end_of_task(LINE, np.zeros(3), np.array([[0.0]]), np.asarray)
    # Fisher (0, 1, 2), mean 1.
    np.testing.assert_allclose(regularizer.state["importance"], 0.5 * (first + np.arange(3)))
    penalty = regularizer.penalty(LINE, np.asarray)
    assert penalty is not None
    gap = np.array([0.5, -1.0, 2.0])
    np.testing.assert_allclose(penalty.value(gap), np.sum((first + np.arange(3)) * gap**2))


@pytest.mark.parametrize("scale", [0.1, 10.0])
def test_the_importance_does_not_depend_on_the_scale_of_the_means_part(scale: float) -> None:
    """One task's importance has the mean 1 before the decay, whatever the size of the Fisher matrix."""
    regularizer = OnlineEwc(1.0, 1.0, 2)
    theta = np.array([0.0, 0.0, np.log(scale)])
    regularizer.end_of_task(LINE, theta, np.array([[1.0], [3.0]]), np.asarray)
    assert regularizer.state["importance"].mean() == pytest.approx(1)
