"""An update raises the surrogate inside the trust region; its solvers, and the step with a penalty."""

import numpy as np
import pytest

from gym_extensions.baselines.agent import Array
from gym_extensions.baselines.trust_region import update
from gym_extensions.baselines.trust_region.policy import Architecture, Batch, mean_and_log_sigma, mean_kl
from gym_extensions.baselines.trust_region.update import Curvature, TrustRegion, updated

from .policies import ARCHITECTURES, each_architecture, random_batch, random_policy, surrogate


def kl_of(architecture: Architecture, old: Array, new: Array, batch: Batch) -> float:
    """The divergence of the new policy from the old one."""
    policies = (mean_and_log_sigma(architecture, theta, batch.observations) for theta in (old, new))
    return mean_kl(*next(policies), *next(policies))


@each_architecture
@pytest.mark.parametrize("max_kl", [0.01, 0.04])
@pytest.mark.parametrize("seed", range(5))
def test_an_update_raises_the_surrogate_in_bounds(
    architecture: Architecture, max_kl: float, seed: int
) -> None:
    theta, batch = random_policy(architecture, seed).astype(np.float32), random_batch(200, seed)
    columns = (batch.observations, batch.actions, batch.advantages)
    batch = Batch(*(column.astype(np.float32) for column in columns))
    new = updated(architecture, theta, batch, TrustRegion(max_kl, damping=1e-5))
    assert surrogate(architecture, theta, new, batch) > 0
    assert max_kl / 5 < kl_of(architecture, theta, new, batch) <= max_kl


@each_architecture
@pytest.mark.parametrize("advantage", [0.0, np.nan])
def test_an_update_without_advantages_changes_nothing(architecture: Architecture, advantage: float) -> None:
    theta, batch = random_policy(architecture), random_batch()
    flat = Batch(batch.observations, batch.actions, np.full(len(batch.actions), advantage))
    assert np.array_equal(updated(architecture, theta, flat, TrustRegion(0.01, 0.1)), theta)


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
    solution, image = update.conjugate_gradient(lambda v: matrix @ v, target, iterations=3 * size)
    np.testing.assert_allclose(image, matrix @ solution, atol=1e-9)
    # It stops at a residual of 1e-5, and no eigenvalue is below 1.
    np.testing.assert_allclose(solution, np.linalg.solve(matrix, target), rtol=0, atol=1e-5)


def test_one_iteration_of_conjugate_gradient_is_the_steepest_descent_step_by_hand() -> None:
    # A = diag(1, 3), b = (1, 1): bᵀb / bᵀAb = 2 / 4.
    solution, image = update.conjugate_gradient(
        lambda vector: np.array([1, 3]) * vector, np.ones(2), iterations=1
    )
    np.testing.assert_allclose((solution, image), ([0.5, 0.5], [0.5, 1.5]))


class Pull:
    """c/2 · ‖θ − θ*‖², the simplest penalty."""

    def __init__(self, coefficient: float, anchor: Array) -> None:
        self.coefficient, self.anchor = coefficient, anchor

    def value(self, theta: Array) -> float:
        return float(0.5 * self.coefficient * np.sum((theta - self.anchor) ** 2))

    def gradient(self, theta: Array) -> Array:
        slope: Array = self.coefficient * (theta - self.anchor)
        return slope

    def curvature(self, theta: Array) -> Curvature:
        return Curvature(lambda vector: self.coefficient * vector, self.coefficient * np.ones_like(theta))


def step(fisher: Array, slope: Array, bend: Array, max_kl: float, damping: float = 0.1) -> Array:
    region, curvature = TrustRegion(max_kl, damping, 50), Curvature(lambda v: bend @ v, np.diag(bend))
    result = update.step_within(region, lambda vector: fisher @ vector, slope, curvature)
    assert result is not None
    return result


def test_without_curvature_the_step_is_the_natural_step() -> None:
    rng = np.random.default_rng(0)
    root, slope = rng.standard_normal((6, 6)), rng.standard_normal(6)
    fisher = root @ root.T + np.eye(6)
    natural = update.step_within(TrustRegion(0.04, 0.1, 50), lambda vector: fisher @ vector, slope)
    assert natural is not None
    np.testing.assert_allclose(step(fisher, slope, np.zeros((6, 6)), 0.04), natural, rtol=1e-8)


def test_a_step_by_hand() -> None:
    # F = I, g = (3, 4), δ = 1/2, so β = √(25 / 1) = 5. With H = diag(0, 5): d = (3, 4 / 2) and
    # the best multiple along d is gᵀd / dᵀHd = 17 / 20, limited by √(2δ / dᵀFd) = 1 / √13.
    np.testing.assert_allclose(
        step(np.eye(2), np.array([3.0, 4.0]), np.diag([0.0, 5.0]), 0.5), np.array([3, 2]) / np.sqrt(13)
    )


@pytest.mark.parametrize("strength", [0.1, 10.0, 1e4])
def test_a_step_stays_in_the_trust_region_and_raises_the_quadratic_model(strength: float) -> None:
    rng = np.random.default_rng(1)
    root, slope = rng.standard_normal((6, 6)), rng.standard_normal(6)
    fisher, bend = root @ root.T + 0.1 * np.eye(6), np.diag(strength * rng.exponential(size=6))
    result = step(fisher, slope, bend, 0.04)
    assert 0.5 * result @ fisher @ result <= 0.04 * (1 + 1e-9)
    assert slope @ result - 0.5 * result @ bend @ result > 0


def test_a_penalty_without_a_binding_trust_region_is_minimized_at_once() -> None:
    # One dimension: the maximum of g s − h s² / 2 is at g / h = .01, well inside ½ s² ≤ 8.
    np.testing.assert_allclose(step(np.eye(1), np.ones(1), 100.0 * np.eye(1), 8.0), [0.01])


def test_no_step_is_made_along_a_gradient_of_zero_or_one_that_is_not_finite() -> None:
    for slope in (np.zeros(3), np.full(3, np.nan)):
        curvature = Curvature(lambda vector: vector)
        assert update.step_within(TrustRegion(0.04, 0.1), lambda v: v, slope, curvature) is None


@pytest.mark.parametrize("coefficient", [0.01, 1.0, 100.0])
def test_an_update_raises_surrogate_minus_penalty_within_the_bound(coefficient: float) -> None:
    architecture, theta, batch = ARCHITECTURES[0], random_policy(ARCHITECTURES[0]), random_batch(200)
    penalty = Pull(coefficient, theta + 0.1)
    new = updated(architecture, theta, batch, TrustRegion(0.04, 0.1), penalty=penalty)
    assert 0 < kl_of(architecture, theta, new, batch) <= 0.04
    assert surrogate(architecture, theta, new, batch) - penalty.value(new) > -penalty.value(theta)
    if coefficient == 100:
        assert penalty.value(new) < penalty.value(theta)


class Wall(Pull):
    """A penalty that is much larger than its gradient and its curvature at the old parameters say."""

    def value(self, theta: Array) -> float:
        return float(1e4 * np.sum((theta - self.anchor) ** 4))

    def gradient(self, theta: Array) -> Array:
        slope: Array = 4e4 * (theta - self.anchor) ** 3
        return slope

    def curvature(self, theta: Array) -> Curvature:
        return Curvature(lambda vector: 0 * vector, np.zeros_like(theta))


def test_the_line_search_shortens_a_step_that_raises_the_surrogate_and_lowers_it_minus_the_penalty() -> None:
    architecture, theta, batch = ARCHITECTURES[0], random_policy(ARCHITECTURES[0]), random_batch(200)
    region, penalty = TrustRegion(0.04, 0.1), Wall(1.0, theta)
    free = updated(architecture, theta, batch, region)
    gain = surrogate(architecture, theta, free, batch)
    assert gain - penalty.value(free) < 0 < gain
    new = updated(architecture, theta, batch, region, penalty=penalty)
    assert 0 < np.linalg.norm(new - theta) < 0.9 * np.linalg.norm(free - theta)
    assert surrogate(architecture, theta, new, batch) - penalty.value(new) > 0


def test_an_update_of_some_parameters_leaves_the_others_bit_by_bit() -> None:
    architecture, theta, batch = ARCHITECTURES[0], random_policy(ARCHITECTURES[0]), random_batch(200)
    trainable = (np.arange(len(theta)) % 3 == 0).astype(float)
    for penalty in (None, Pull(1.0, theta + 0.1)):
        region = TrustRegion(0.04, 0.1)
        new = updated(architecture, theta, batch, region, penalty=penalty, trainable=trainable)
        assert np.array_equal(new != theta, trainable == 1)
