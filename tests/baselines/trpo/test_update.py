"""An update raises the surrogate inside the trust region, or changes nothing; its two solvers."""

from __future__ import annotations

import numpy as np
import pytest

from gym_extensions.baselines.trpo.policy import (
    Architecture,
    Batch,
    divergence,
    log_density,
    mean_and_log_sigma,
    surrogate,
)
from gym_extensions.baselines.trpo.update import TrustRegion, conjugate_gradient, line_search, updated

from .policies import ARCHITECTURES, random_batch, random_policy

each_architecture = pytest.mark.parametrize("architecture", ARCHITECTURES, ids=["linear", "tanh"])


@each_architecture
@pytest.mark.parametrize("max_kl", [0.01, 0.04])
@pytest.mark.parametrize("seed", range(5))
def test_an_update_raises_the_surrogate_within_the_bound(
    architecture: Architecture, max_kl: float, seed: int
) -> None:
    theta, batch = random_policy(architecture, seed).astype(np.float32), random_batch(200, seed)
    columns = (batch.observations, batch.actions, batch.advantages)
    batch = Batch(*(column.astype(np.float32) for column in columns))
    new = updated(architecture, theta, batch, TrustRegion(max_kl, damping=1e-5))
    old_mean, old_log_sigma = mean_and_log_sigma(architecture, theta, batch.observations)
    old = log_density(old_mean, old_log_sigma, batch.actions)
    assert surrogate(architecture, new, batch, old) > surrogate(architecture, theta, batch, old)
    kl = divergence(old_mean, old_log_sigma, *mean_and_log_sigma(architecture, new, batch.observations))
    assert max_kl / 5 < kl <= max_kl


@each_architecture
def test_an_update_with_zero_advantages_changes_nothing(architecture: Architecture) -> None:
    theta, batch = random_policy(architecture), random_batch()
    flat = Batch(batch.observations, batch.actions, np.zeros(len(batch.actions)))
    assert np.array_equal(updated(architecture, theta, flat, TrustRegion(0.01, 0.1)), theta)


@each_architecture
def test_an_update_with_advantages_that_are_not_finite_changes_nothing(architecture: Architecture) -> None:
    theta, batch = random_policy(architecture), random_batch()
    broken = Batch(batch.observations, batch.actions, np.full(len(batch.actions), np.nan))
    assert np.array_equal(updated(architecture, theta, broken, TrustRegion(0.01, 0.1)), theta)


@each_architecture
@pytest.mark.parametrize("seed", range(5))
def test_log_sigma_stays_above_its_lower_bound_and_may_rise(architecture: Architecture, seed: int) -> None:
    theta, batch, outputs = random_policy(architecture, seed), random_batch(200, seed), architecture.sizes[-1]
    free = updated(architecture, theta, batch, TrustRegion(0.04, 0.1))[-outputs:]
    bound = float(theta[-outputs:].min())
    bounded = updated(architecture, theta, batch, TrustRegion(0.04, 0.1, least_log_sigma=bound))[-outputs:]
    at_bound = theta[-outputs:] == bound
    assert (bounded >= bound).all()
    assert np.array_equal(bounded[at_bound] > bound, free[at_bound] > bound)


@each_architecture
def test_a_component_at_the_bound_takes_no_part_of_the_trust_region(architecture: Architecture) -> None:
    theta, batch, outputs = random_policy(architecture), random_batch(), architecture.sizes[-1]
    # Of actions at the mean, with equal advantages, the likelihood rises by a smaller σ alone.
    mean, _ = mean_and_log_sigma(architecture, theta, batch.observations)
    batch = Batch(batch.observations, mean, np.ones(len(mean)))
    region = TrustRegion(0.04, 0.1, least_log_sigma=float(theta[-outputs:].max()))
    at_bound = np.concatenate([theta[:-outputs], np.full(outputs, theta[-outputs:].max())])
    assert (
        updated(architecture, at_bound, batch, TrustRegion(0.04, 0.1))[-outputs:] < at_bound[-outputs:]
    ).all()
    assert np.array_equal(updated(architecture, at_bound, batch, region), at_bound)


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
