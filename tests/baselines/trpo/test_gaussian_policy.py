"""The policy's surrogate, divergence and Fisher product, for a linear and for a tanh mean."""

from __future__ import annotations

import numpy as np
import pytest

from gym_extensions.baselines.agent import Array
from gym_extensions.baselines.trpo.policy import (
    BLOCK,
    Architecture,
    Batch,
    divergence,
    fisher_product,
    initial_policy,
    log_density,
    mean_and_log_sigma,
    surrogate,
    surrogate_gradient,
)

from .policies import ARCHITECTURES, SIZES, numeric_gradient, random_batch, random_policy

each_architecture = pytest.mark.parametrize("architecture", ARCHITECTURES, ids=["linear", "tanh"])


def test_the_mean_is_the_output_or_its_tanh() -> None:
    linear, squashed = Architecture(SIZES, "tanh"), Architecture(SIZES, "tanh", tanh_mean=True)
    theta, observations = random_policy(linear), random_batch().observations
    output, _ = mean_and_log_sigma(linear, theta, observations)
    mean, _ = mean_and_log_sigma(squashed, theta, observations)
    assert np.abs(output).max() > 1
    np.testing.assert_allclose(mean, np.tanh(output))


def test_the_initial_log_sigma_is_the_argument() -> None:
    theta = initial_policy(Architecture(SIZES), np.random.default_rng(0), 0.01, log_sigma=-1.0)
    mean, log_sigma = mean_and_log_sigma(Architecture(SIZES), theta, random_batch().observations)
    assert log_sigma.tolist() == [-1.0, -1.0]
    assert np.abs(mean).max() < 0.1


def test_the_log_density_of_a_gaussian_by_hand() -> None:
    # (3 − 1) / 2 = 1 and (0 − 0) / 1 = 0: −½ · 1 − log 2 − log 1.
    density = log_density(np.array([[1.0, 0.0]]), np.log([2.0, 1.0]), np.array([[3.0, 0.0]]))
    np.testing.assert_allclose(density, [-0.5 - np.log(2)])


@each_architecture
def test_the_surrogates_gradient_agrees_with_finite_differences(architecture: Architecture) -> None:
    theta, batch = random_policy(architecture), random_batch()
    old = log_density(*mean_and_log_sigma(architecture, theta, batch.observations), batch.actions)
    expected = numeric_gradient(lambda at: surrogate(architecture, at, batch, old), theta)
    np.testing.assert_allclose(surrogate_gradient(architecture, theta, batch), expected, atol=1e-7)


@each_architecture
def test_the_gradient_of_a_batch_of_several_blocks_is_the_mean_of_its_parts(
    architecture: Architecture,
) -> None:
    theta, batch = random_policy(architecture), random_batch(2 * BLOCK)
    halves = [
        Batch(batch.observations[rows], batch.actions[rows], batch.advantages[rows])
        for rows in (slice(None, BLOCK), slice(BLOCK, None))
    ]
    expected = np.mean([surrogate_gradient(architecture, theta, half) for half in halves], axis=0)
    np.testing.assert_allclose(surrogate_gradient(architecture, theta, batch), expected, atol=1e-12)


@each_architecture
def test_the_divergences_gradient_is_zero_at_the_old_policy_and_agrees_elsewhere(
    architecture: Architecture,
) -> None:
    theta, observations = random_policy(architecture), random_batch().observations
    old = mean_and_log_sigma(architecture, theta, observations)

    def kl(at: Array) -> float:
        return divergence(*old, *mean_and_log_sigma(architecture, at, observations))

    np.testing.assert_allclose(numeric_gradient(kl, theta), 0, atol=1e-8)
    assert kl(random_policy(architecture, seed=1)) > 0.1


def test_the_divergence_of_two_gaussians_by_hand() -> None:
    # Means 0 and 1, σ 1 and 2: log 2 + (1 + 1) / 8 − 1/2.
    kl = divergence(np.zeros((1, 1)), np.zeros(1), np.ones((1, 1)), np.array([np.log(2.0)]))
    assert kl == pytest.approx(np.log(2) + 0.25 - 0.5)


@each_architecture
def test_the_fisher_product_is_the_divergences_second_derivative(architecture: Architecture) -> None:
    theta, observations = random_policy(architecture), random_batch().observations
    old = mean_and_log_sigma(architecture, theta, observations)

    def kl(at: Array) -> float:
        return divergence(*old, *mean_and_log_sigma(architecture, at, observations))

    width, unit = 1e-4, np.eye(len(theta))
    rows = slice(None, None, 7)  # a seventh of the dense matrix takes a seventh of the time
    dense = np.array(
        [
            numeric_gradient(kl, theta + width * row) / (2 * width)
            - numeric_gradient(kl, theta - width * row) / (2 * width)
            for row in unit[rows]
        ]
    )
    product = fisher_product(architecture, theta, observations, damping=0.0)
    fisher = np.array([product(row) for row in unit])
    np.testing.assert_allclose(fisher[rows], dense, atol=3e-4)
    np.testing.assert_allclose(fisher, fisher.T, atol=1e-12)


@each_architecture
def test_damping_adds_to_the_diagonal(architecture: Architecture) -> None:
    theta, observations = random_policy(architecture), random_batch().observations
    vector = np.random.default_rng(5).standard_normal(theta.shape)
    plain, damped = (
        fisher_product(architecture, theta, observations, damping)(vector) for damping in (0.0, 0.5)
    )
    np.testing.assert_allclose(damped - plain, 0.5 * vector)
