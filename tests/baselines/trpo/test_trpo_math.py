"""TRPO's pure functions against dense algebra, finite differences and sums by hand."""

from __future__ import annotations

import numpy as np
import pytest

from gym_extensions.baselines.trpo.gae import advantages
from gym_extensions.baselines.trpo.gaussian_policy import (
    Batch,
    divergence,
    fisher_product,
    initial_policy,
    log_density,
    mean_and_log_sigma,
    surrogate,
    surrogate_gradient,
)
from gym_extensions.baselines.trpo.mlp import forward, gradient, layers, parameter_count, slopes, tangent
from gym_extensions.baselines.trpo.optimize import conjugate_gradient, line_search
from gym_extensions.baselines.trpo.update import TrustRegion, updated

SIZES = (3, 6, 5, 2)


def a_policy(seed: int = 0) -> np.ndarray:
    rng = np.random.default_rng(seed)
    theta = initial_policy(SIZES, rng, 1.0).astype(np.float64)
    return theta + 0.1 * rng.standard_normal(theta.shape)


def a_batch(n: int = 40, seed: int = 1) -> Batch:
    rng = np.random.default_rng(seed)
    return Batch(rng.standard_normal((n, 3)), rng.standard_normal((n, 2)), rng.standard_normal(n))


def numeric_gradient(function, at, width=1e-6):
    found = np.empty_like(at)
    for index in range(len(at)):
        step = np.zeros_like(at)
        step[index] = width
        found[index] = (function(at + step) - function(at - step)) / (2 * width)
    return found


@pytest.mark.parametrize("size", [1, 2, 5, 20])
def test_conjugate_gradient_solves_a_positive_definite_system(size):
    rng = np.random.default_rng(size)
    root = rng.standard_normal((size, size))
    matrix = root @ root.T + np.eye(size)
    target = rng.standard_normal(size)
    found = conjugate_gradient(lambda vector: matrix @ vector, target, iterations=3 * size, tolerance=1e-24)
    np.testing.assert_allclose(found, np.linalg.solve(matrix, target), rtol=1e-7, atol=1e-9)


def test_conjugate_gradient_starts_at_zero_and_stays_there_for_a_zero_target():
    assert not conjugate_gradient(lambda vector: 2 * vector, np.zeros(4)).any()


def test_one_step_of_conjugate_gradient_is_the_steepest_descent_step_by_hand():
    # A = diag(1, 3), b = (1, 1): bᵀb / bᵀAb = 2 / 4.
    found = conjugate_gradient(lambda vector: np.array([1.0, 3.0]) * vector, np.ones(2), iterations=1)
    np.testing.assert_allclose(found, [0.5, 0.5])


def test_the_line_search_takes_the_first_accepted_step():
    found, tries = line_search(lambda at: at[0] <= 0.7, np.zeros(1), np.ones(1), shrink=0.8)
    assert (tries, found[0]) == (2, pytest.approx(0.64))


def test_the_line_search_that_accepts_nothing_stays():
    start = np.array([3.0])
    found, tries = line_search(lambda at: False, start, np.ones(1), tries=4)
    assert tries == 4
    assert found is start


def test_a_network_of_one_hidden_unit_by_hand():
    # weights 2, bias 1, ReLU; then −3, bias .5: x = 1 gives 3, then −8.5; x = −1 gives 0, then .5.
    views = layers((1, 1, 1), np.array([2.0, 1.0, -3.0, 0.5]))
    assert forward(views, np.array([[1.0], [-1.0]]))[-1].ravel().tolist() == [-8.5, 0.5]
    assert parameter_count((1, 1, 1)) == 4


def test_the_networks_derivatives_agree_with_finite_differences():
    rng = np.random.default_rng(3)
    theta = rng.standard_normal(parameter_count(SIZES))
    inputs, upstream = rng.standard_normal((7, 3)), rng.standard_normal((7, 2))

    def value(at):
        return float(np.sum(upstream * forward(layers(SIZES, at), inputs)[-1]))

    views = layers(SIZES, theta)
    values = forward(views, inputs)
    found = gradient(views, values, slopes(values), upstream)
    np.testing.assert_allclose(found, numeric_gradient(value, theta), atol=1e-6)
    direction = rng.standard_normal(theta.shape)
    moved = tangent(views, values, slopes(values), layers(SIZES, direction))
    assert np.sum(moved * upstream) == pytest.approx(found @ direction)


def test_the_surrogates_gradient_agrees_with_finite_differences():
    theta, batch = a_policy(), a_batch()
    old = log_density(*mean_and_log_sigma(SIZES, theta, batch.observations), batch.actions)
    expected = numeric_gradient(lambda at: surrogate(SIZES, at, batch, old), theta)
    np.testing.assert_allclose(surrogate_gradient(SIZES, theta, batch), expected, atol=1e-7)


def test_the_fisher_product_is_the_divergences_second_derivative():
    theta, seen = a_policy(), a_batch().observations
    old = mean_and_log_sigma(SIZES, theta, seen)

    def kl(at):
        return divergence(*old, *mean_and_log_sigma(SIZES, at, seen))

    width, eye = 1e-4, np.eye(len(theta))
    dense = np.array(
        [
            numeric_gradient(kl, theta + width * row) / (2 * width)
            - numeric_gradient(kl, theta - width * row) / (2 * width)
            for row in eye
        ]
    )
    product = fisher_product(SIZES, theta, seen, damping=0.0)
    found = np.array([product(row) for row in eye])
    np.testing.assert_allclose(found, dense, atol=2e-4)
    np.testing.assert_allclose(found, found.T, atol=1e-12)


def test_damping_adds_to_the_diagonal():
    theta, seen = a_policy(), a_batch().observations
    vector = np.random.default_rng(5).standard_normal(theta.shape)
    plain, damped = (fisher_product(SIZES, theta, seen, damping)(vector) for damping in (0.0, 0.5))
    np.testing.assert_allclose(damped - plain, 0.5 * vector)


def test_the_divergence_of_two_gaussians_by_hand():
    # means 0 and 1, σ 1 and 2: log 2 + (1 + 1) / 8 − 1/2.
    found = divergence(np.zeros((1, 1)), np.zeros(1), np.ones((1, 1)), np.array([np.log(2.0)]))
    assert found == pytest.approx(np.log(2) + 0.25 - 0.5)


@pytest.mark.parametrize("seed", range(5))
def test_an_update_raises_the_surrogate_and_holds_the_bound(seed):
    theta, batch = a_policy(seed).astype(np.float32), a_batch(200, seed)
    batch = Batch(
        *(part.astype(np.float32) for part in (batch.observations, batch.actions, batch.advantages))
    )
    new = updated(SIZES, theta, batch, TrustRegion(max_kl=0.01))
    old_mean, old_log_sigma = mean_and_log_sigma(SIZES, theta, batch.observations)
    old = log_density(old_mean, old_log_sigma, batch.actions)
    assert surrogate(SIZES, new, batch, old) > surrogate(SIZES, theta, batch, old)
    apart = divergence(old_mean, old_log_sigma, *mean_and_log_sigma(SIZES, new, batch.observations))
    assert 0.002 < apart <= 0.01


def test_an_update_without_any_advantage_changes_nothing():
    theta, batch = a_policy(), a_batch()
    still = Batch(batch.observations, batch.actions, np.zeros(len(batch.actions)))
    assert np.array_equal(updated(SIZES, theta, still, TrustRegion()), theta)


def lane(*values: float) -> np.ndarray:
    return np.array(values)[:, None]


def flags(*values: int) -> np.ndarray:
    return np.array(values, bool)[:, None]


GAE = [
    # discount .5, λ .5; rewards 1, 2; values 4, 2, 8.
    # Second: 2 + .5·8 − 2 = 4; first: 1 + .5·2 − 4 + .25·4 = −1.
    ("goes on", flags(0, 0), flags(0, 0), [-1.0, 4.0]),
    # The last step ends it: 2 − 2 = 0; first: −2 + .25·0.
    ("terminated", flags(0, 1), flags(0, 0), [-2.0, 0.0]),
    # Cut by the time limit: worth the next state, as if it went on.
    ("truncated", flags(0, 0), flags(0, 1), [-1.0, 4.0]),
    # The first step is cut: it is worth its next state and takes nothing from what comes after the reset.
    ("truncated first", flags(0, 0), flags(1, 0), [-2.0, 4.0]),
    ("terminated first", flags(1, 0), flags(0, 0), [-3.0, 4.0]),
]


@pytest.mark.parametrize(
    ("terminated", "truncated", "expected"), [row[1:] for row in GAE], ids=[r[0] for r in GAE]
)
def test_advantages_by_hand(terminated, truncated, expected):
    found = advantages(lane(1, 2), lane(4, 2, 8), terminated, truncated, discount=0.5, trace_decay=0.5)
    assert found.ravel().tolist() == expected


def test_with_lambda_one_the_advantage_is_the_discounted_return_minus_the_value():
    rewards, values = np.arange(5.0)[:, None], np.arange(6.0)[::-1, None] ** 2
    never = np.zeros((5, 1), bool)
    found = advantages(rewards, values, never, never, discount=0.9, trace_decay=1.0)
    returns = [sum(0.9 ** (k - t) * k for k in range(t, 5)) + 0.9 ** (5 - t) * values[5, 0] for t in range(5)]
    np.testing.assert_allclose(found.ravel(), np.array(returns) - values[:5, 0])
