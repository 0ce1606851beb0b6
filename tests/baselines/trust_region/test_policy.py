"""The policy of TRPO: its network, derivatives and moments, and surrogate, divergence and Fisher product."""

import numpy as np
import pytest

from gym_extensions.baselines.agent import Array
from gym_extensions.baselines.trust_region import policy

from .policies import SIZES, each_architecture, numeric_gradient, random_batch, random_policy, surrogate


@pytest.mark.parametrize(
    ("activation", "expected"),
    [
        ("relu", [-8.5, 0.5]),  # x = 1: ReLU(3) = 3, 3 · −3 + .5; x = −1: ReLU(−1) = 0.
        ("tanh", [-3 * np.tanh(3) + 0.5, 3 * np.tanh(1) + 0.5]),
    ],
)
def test_a_network_of_one_hidden_unit_by_hand(activation: str, expected: list[float]) -> None:
    # Weights 2 and −3, biases 1 and .5, inputs 1 and −1.
    architecture, theta = policy.Architecture((1, 1, 1), activation), np.array([2.0, 1.0, -3.0, 0.5])
    output = policy.forward(architecture, theta, np.array([[1.0], [-1.0]]))[-1]
    np.testing.assert_allclose(output.ravel(), expected)


@pytest.mark.parametrize("name", policy.ACTIVATIONS)
@pytest.mark.parametrize("rows", [7, policy.BLOCK + 7])
def test_the_derivatives_agree_with_finite_differences(name: str, rows: int) -> None:
    rng, architecture = np.random.default_rng(3), policy.Architecture(SIZES, name)
    theta = rng.standard_normal(policy.parameter_count(SIZES))
    inputs, upstream = rng.standard_normal((rows, 3)), rng.standard_normal((rows, 2))

    def value(at: Array) -> float:
        return float(np.sum(upstream * policy.outputs(architecture, at, inputs)))

    values = policy.forward(architecture, theta, inputs)
    backward = policy.gradient(architecture, theta, values, upstream)
    np.testing.assert_allclose(backward, numeric_gradient(value, theta), atol=1e-5)
    direction = rng.standard_normal(theta.shape)
    change = policy.jvp(SIZES, theta, policy.ACTIVATIONS[name], values, direction)
    assert np.sum(change * upstream) == pytest.approx(backward @ direction)


def test_the_last_layer_starts_smaller_by_its_scale() -> None:
    large, small = (policy.initial(SIZES, np.random.default_rng(0), scale) for scale in (1.0, 0.01))
    (*hidden_large, last_large), (*hidden_small, last_small) = (
        policy.layers(SIZES, large),
        policy.layers(SIZES, small),
    )
    for (left, _), (right, _) in zip(hidden_large, hidden_small, strict=True):
        np.testing.assert_array_equal(left, right)
    np.testing.assert_allclose(last_small[0], 0.01 * last_large[0], rtol=1e-6)
    assert not last_small[1].any()


@pytest.mark.parametrize("cuts", [[], [1], [10, 11, 500]])
@pytest.mark.parametrize("offset", [0.0, 1e4])
def test_merged_moments_are_those_of_all_observations_at_once(cuts: list[int], offset: float) -> None:
    observations = offset + np.random.default_rng(0).standard_normal((1000, 4)) * [1e-3, 1, 10, 1e3]
    moments = policy.no_moments(4)
    for part in np.split(observations, cuts):
        moments = policy.merge(moments, part)
    assert moments.count == 1000
    np.testing.assert_allclose(moments.mean, observations.mean(axis=0), rtol=1e-10)
    np.testing.assert_allclose(moments.squares / 1000, observations.var(axis=0), rtol=1e-6)


def test_outliers_are_clipped() -> None:
    moments = policy.Moments(100, np.array([1.0]), np.array([400.0]))  # Standard deviation 2.
    scaled = policy.standardize(moments, np.array([[1.0], [5.0], [1e6], [-1e6]]))
    np.testing.assert_allclose(scaled.ravel(), [0, 2, policy.CLIP, -policy.CLIP], rtol=1e-6)
    assert scaled.dtype == np.float32


def test_the_mean_is_the_output_or_its_tanh() -> None:
    linear, squashed = policy.Architecture(SIZES, "tanh"), policy.Architecture(SIZES, "tanh", tanh_mean=True)
    theta, observations = random_policy(linear), random_batch().observations
    output, _ = policy.mean_and_log_sigma(linear, theta, observations)
    mean, _ = policy.mean_and_log_sigma(squashed, theta, observations)
    assert np.abs(output).max() > 1
    np.testing.assert_allclose(mean, np.tanh(output))


def test_the_log_density_of_a_gaussian_by_hand() -> None:
    # (3 − 1) / 2 = 1 and (0 − 0) / 1 = 0: −½ · 1 − log 2 − log 1.
    density = policy.log_density(np.array([[1.0, 0.0]]), np.log([2.0, 1.0]), np.array([[3.0, 0.0]]))
    np.testing.assert_allclose(density, [-0.5 - np.log(2)])


@each_architecture
def test_the_surrogates_gradient_agrees_with_finite_differences(architecture: policy.Architecture) -> None:
    theta, batch = random_policy(architecture), random_batch()
    expected = numeric_gradient(lambda at: surrogate(architecture, theta, at, batch), theta)
    values = policy.forward(architecture, theta, batch.observations)
    gradient = policy.surrogate_gradient(architecture, theta, batch, values)
    np.testing.assert_allclose(gradient, expected, atol=1e-7)


def test_the_divergence_of_two_gaussians_by_hand() -> None:
    # Means 0 and 1, σ 1 and 2: log 2 + (1 + 1) / 8 − 1/2.
    kl = policy.mean_kl(np.zeros((1, 1)), np.zeros(1), np.ones((1, 1)), np.array([np.log(2.0)]))
    assert kl == pytest.approx(np.log(2) + 0.25 - 0.5)


@each_architecture
def test_the_fisher_product_is_the_divergences_second_derivative(architecture: policy.Architecture) -> None:
    theta, observations = random_policy(architecture), random_batch().observations
    old = policy.mean_and_log_sigma(architecture, theta, observations)

    def kl(at: Array) -> float:
        return policy.mean_kl(*old, *policy.mean_and_log_sigma(architecture, at, observations))

    width, unit = 1e-4, np.eye(len(theta))
    rows = slice(None, None, 7)  # a seventh of the dense matrix takes a seventh of the time
    dense = np.array(
        [
            numeric_gradient(kl, theta + width * row) / (2 * width)
            - numeric_gradient(kl, theta - width * row) / (2 * width)
            for row in unit[rows]
        ]
    )
    values = policy.forward(architecture, theta, observations)
    product = policy.fisher_product(architecture, theta, values, damping=0.0)
    fisher = np.array([product(row) for row in unit])
    np.testing.assert_allclose(fisher[rows], dense, atol=3e-4)
    np.testing.assert_allclose(fisher, fisher.T, atol=1e-12)


@each_architecture
def test_damping_adds_to_the_diagonal(architecture: policy.Architecture) -> None:
    theta, observations = random_policy(architecture), random_batch().observations
    vector = np.random.default_rng(5).standard_normal(theta.shape)
    values = policy.forward(architecture, theta, observations)
    plain, damped = (policy.fisher_product(architecture, theta, values, each)(vector) for each in (0.0, 0.5))
    np.testing.assert_allclose(damped - plain, 0.5 * vector)
