"""Running moments against the moments of all observations at once."""

from __future__ import annotations

import numpy as np
import pytest

from gym_extensions.baselines.trpo.policy import (
    CLIP,
    Moments,
    merge,
    no_moments,
    standardize,
)


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


def test_moments_are_summed_in_float64_for_float32_observations() -> None:
    observations = (100 + np.random.default_rng(0).standard_normal((50_000, 1))).astype(np.float32)
    moments = merge(no_moments(1), observations)
    assert moments.mean.dtype == moments.squares.dtype == np.float64
    np.testing.assert_allclose(moments.mean, observations.astype(np.float64).mean(axis=0), rtol=1e-12)


def test_merging_leaves_the_old_moments_as_they_are() -> None:
    old = merge(no_moments(2), np.ones((3, 2)))
    mean, squares = old.mean.copy(), old.squares.copy()
    merge(old, np.full((5, 2), 7.0))
    np.testing.assert_array_equal(old.mean, mean)
    np.testing.assert_array_equal(old.squares, squares)


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


def test_a_component_that_never_changes_is_zero() -> None:
    observations = np.full((10, 1), 0.3)
    np.testing.assert_allclose(standardize(merge(no_moments(1), observations), observations), 0, atol=1e-6)


def test_rounding_errors_of_constant_observations_stay_small() -> None:
    moments = merge(no_moments(1), np.full((50, 1), 3.0))
    assert abs(standardize(moments, np.array([[3.0 + 1e-9]]))[0, 0]) < 1e-5
