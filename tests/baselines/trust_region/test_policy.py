"""The policy of TRPO: its network, derivatives and moments, and surrogate, divergence and Fisher product."""

from __future__ import annotations

import numpy as np
import pytest

from gym_extensions.baselines.agent import Array
from gym_extensions.baselines.trust_region.policy import (
    ACTIVATIONS,
    BLOCK,
    CLIP,
    Architecture,
    Batch,
    Moments,
    divergence,
    fisher_product,
    forward,
    gradient,
    initial,
    layers,
    log_density,
    mean_and_log_sigma,
    merge,
    no_moments,
    parameter_count,
    standardize,
    surrogate_gradient,
    tangent,
)

from .policies import ARCHITECTURES, SIZES, numeric_gradient, random_batch, random_policy, surrogate


@pytest.mark.parametrize(
    ("activation", "expected"),
    [
        ("relu", [-8.5, 0.5]),  # x = 1: ReLU(3) = 3, 3 · −3 + .5; x = −1: ReLU(−1) = 0.
        ("tanh", [-3 * np.tanh(3) + 0.5, 3 * np.tanh(1) + 0.5]),
    ],
)
def test_a_network_of_one_hidden_unit_by_hand(activation: str, expected: list[float]) -> None:
    # Weights 2 and −3, biases 1 and .5, inputs 1 and −1.
    views = layers((1, 1, 1), np.array([2.0, 1.0, -3.0, 0.5]))
    output = forward(views, np.array([[1.0], [-1.0]]), ACTIVATIONS[activation])[-1]
    np.testing.assert_allclose(output.ravel(), expected)


@pytest.mark.parametrize("name", ACTIVATIONS)
def test_the_derivatives_agree_with_finite_differences(name: str) -> None:
    rng, activation = np.random.default_rng(3), ACTIVATIONS[name]
    theta = rng.standard_normal(parameter_count(SIZES))
    inputs, upstream = rng.standard_normal((7, 3)), rng.standard_normal((7, 2))

    def value(at: Array) -> float:
        return float(np.sum(upstream * forward(layers(SIZES, at), inputs, activation)[-1]))

    views = layers(SIZES, theta)
    values = forward(views, inputs, activation)
    hidden_slopes = [activation.slope(hidden) for hidden in values[1:-1]]
    backward = gradient(views, values, hidden_slopes, upstream)
    np.testing.assert_allclose(backward, numeric_gradient(value, theta), atol=1e-6)
    direction = rng.standard_normal(theta.shape)
    change = tangent(views, values, hidden_slopes, layers(SIZES, direction))
    assert np.sum(change * upstream) == pytest.approx(backward @ direction)


def test_the_last_layer_starts_smaller_by_its_scale() -> None:
    large, small = (initial(SIZES, np.random.default_rng(0), scale) for scale in (1.0, 0.01))
    (*hidden_large, last_large), (*hidden_small, last_small) = layers(SIZES, large), layers(SIZES, small)
    for (left, _), (right, _) in zip(hidden_large, hidden_small, strict=True):
        np.testing.assert_array_equal(left, right)
    np.testing.assert_allclose(last_small[0], 0.01 * last_large[0], rtol=1e-6)
    assert not last_small[1].any()


@pytest.mark.parametrize("cuts", [[], [1], [10, 11, 500]])
@pytest.mark.parametrize("offset", [0.0, 1e4])
def test_merged_moments_are_those_of_all_observations_at_once(cuts: list[int], offset: float) -> None:
    observations = offset + np.random.default_rng(0).standard_normal((1000, 4)) * [1e-3, 1, 10, 1e3]
    moments = no_moments(4)
    for part in np.split(observations, cuts):
        moments = merge(moments, part)
    assert moments.count == 1000
    np.testing.assert_allclose(moments.mean, observations.mean(axis=0), rtol=1e-10)
    np.testing.assert_allclose(moments.squares / 1000, observations.var(axis=0), rtol=1e-6)


def test_outliers_are_clipped() -> None:
    moments = Moments(100, np.array([1.0]), np.array([400.0]))  # Standard deviation 2.
    scaled = standardize(moments, np.array([[1.0], [5.0], [1e6], [-1e6]]))
    np.testing.assert_allclose(scaled.ravel(), [0, 2, CLIP, -CLIP], rtol=1e-6)
    assert scaled.dtype == np.float32


each_architecture = pytest.mark.parametrize("architecture", ARCHITECTURES, ids=["linear", "tanh"])


def test_the_mean_is_the_output_or_its_tanh() -> None:
    linear, squashed = Architecture(SIZES, "tanh"), Architecture(SIZES, "tanh", tanh_mean=True)
    theta, observations = random_policy(linear), random_batch().observations
    output, _ = mean_and_log_sigma(linear, theta, observations)
    mean, _ = mean_and_log_sigma(squashed, theta, observations)
    assert np.abs(output).max() > 1
    np.testing.assert_allclose(mean, np.tanh(output))


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
