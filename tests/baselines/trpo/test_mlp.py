"""The network's values by hand, its derivatives, and the running moments of its inputs."""

from __future__ import annotations

import numpy as np
import pytest

from gym_extensions.baselines.agent import Array
from gym_extensions.baselines.trpo.policy import (
    ACTIVATIONS,
    CLIP,
    Moments,
    forward,
    gradient,
    initial,
    layers,
    merge,
    no_moments,
    parameter_count,
    slopes,
    standardize,
    tangent,
)

from .policies import SIZES, numeric_gradient


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


def test_parameters_are_counted_with_biases() -> None:
    assert parameter_count((1, 1, 1)) == 4
    assert parameter_count((3, 6, 2)) == 3 * 6 + 6 + 6 * 2 + 2


@pytest.mark.parametrize("name", ACTIVATIONS)
def test_the_derivatives_agree_with_finite_differences(name: str) -> None:
    rng, activation = np.random.default_rng(3), ACTIVATIONS[name]
    theta = rng.standard_normal(parameter_count(SIZES))
    inputs, upstream = rng.standard_normal((7, 3)), rng.standard_normal((7, 2))

    def value(at: Array) -> float:
        return float(np.sum(upstream * forward(layers(SIZES, at), inputs, activation)[-1]))

    views = layers(SIZES, theta)
    values = forward(views, inputs, activation)
    hidden_slopes = slopes(values, activation)
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


def test_merged_moments_by_hand() -> None:
    # 1, 3 have mean 2 and squares 2; with 8 they have mean 4 and squares 9 + 1 + 16.
    first = merge(no_moments(1), np.array([[1.0], [3.0]]))
    assert (first.count, first.mean.tolist(), first.squares.tolist()) == (2, [2.0], [2.0])
    second = merge(first, np.array([[8.0]]))
    assert (second.count, second.mean.tolist()) == (3, [4.0])
    np.testing.assert_allclose(second.squares, [26.0])


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


def test_standardized_observations_have_mean_zero_and_deviation_one() -> None:
    observations = 5 + 3 * np.random.default_rng(0).standard_normal((1000, 2))
    scaled = standardize(merge(no_moments(2), observations), observations)
    assert scaled.dtype == np.float32
    np.testing.assert_allclose(scaled.mean(axis=0), 0, atol=1e-6)
    np.testing.assert_allclose(scaled.std(axis=0), 1, rtol=1e-6)


def test_outliers_are_clipped() -> None:
    moments = Moments(100, np.array([1.0]), np.array([400.0]))  # Standard deviation 2.
    scaled = standardize(moments, np.array([[1.0], [5.0], [1e6], [-1e6]]))
    np.testing.assert_allclose(scaled.ravel(), [0, 2, CLIP, -CLIP], rtol=1e-6)


def test_rounding_errors_of_constant_observations_stay_small() -> None:
    moments = merge(no_moments(1), np.full((50, 1), 3.0))
    assert abs(standardize(moments, np.array([[3.0 + 1e-9]]))[0, 0]) < 1e-5
