"""Penalties, what they anchor and store, which states are sampled, and who owns a weight."""

import numpy as np
import pytest

from gym_extensions.baselines.algorithms import continual
from gym_extensions.baselines.algorithms.packnet import claimed, no_owners, trainable, visible
from gym_extensions.baselines.trust_region.policy import Architecture, log_density, mean_and_log_sigma

from ...trust_region.policies import each_architecture, numeric_gradient, random_policy
from .goals import LINE, end_task, make, on_a_line

PENALTY = continual.Quadratic(0.5, np.array([2.0, 0.0, 1.0]), np.array([1.0, 1.0, -1.0]))
THETA = np.array([2.0, 7.0, 1.0])


def test_a_penalty_by_hand() -> None:
    # .5 / 2 · (2 · 1² + 0 · 6² + 1 · 2²), .5 · (2 · 1, 0 · 6, 1 · 2) and .5 · (2, 0, 1).
    assert PENALTY.value(THETA) == 1.5
    np.testing.assert_allclose(PENALTY.gradient(THETA), [1, 0, 1])
    curvature = PENALTY.curvature(THETA)
    np.testing.assert_allclose(curvature.diagonal, [1, 0, 0.5])
    np.testing.assert_allclose(curvature.product(np.array([1.0, -2.0, 4.0])), [1, 0, 2])


def test_l2_pulls_to_the_parameters_after_the_previous_task_and_not_before() -> None:
    agent = on_a_line("l2", 2.0, 0.0, 0.0, 0.0)
    assert agent._penalty() is None
    for last in (np.ones(3), np.full(3, 5.0)):
        end_task(agent, last, np.zeros((0, 1)))
        assert agent._penalty().value(last + np.array([1, 0, 2])) == 5.0


def test_l2_init_pulls_to_the_initial_parameters_in_every_task() -> None:
    agent = make("l2-init", coefficient=2.0)
    start = agent._theta.astype(float)
    end_task(agent, start + 1, np.zeros((0, 3)))
    assert agent._penalty().value(start) == pytest.approx(0, abs=1e-9)
    assert agent._penalty().value(start + 1) == pytest.approx(len(start))


def test_the_diagonal_of_the_fisher_matrix_by_hand() -> None:
    # ∂μ/∂w = x, ∂μ/∂b = 1; σ = 2, so w: mean(1, 9) / 4, b: 1 / 4, log σ: 2.
    fisher = continual.diagonal_fisher(LINE, np.array([0.3, 0.1, np.log(2)]), np.array([[1.0], [3.0]]))
    np.testing.assert_allclose(fisher, [1.25, 0.25, 2])


@each_architecture
def test_the_diagonal_is_the_mean_squared_gradient_of_the_log_density(architecture: Architecture) -> None:
    rng, theta = np.random.default_rng(3), random_policy(architecture)
    theta[-2:] = [-0.5, 0.2]
    state = rng.standard_normal((1, 3))
    exact = continual.diagonal_fisher(architecture, theta, state)
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
    agent = on_a_line("online-ewc", 4.0, 0.0, 0.0, 0.0)
    agent.decay = 0.5
    end_task(agent, np.array([0, 0, np.log(2)]), np.array([[1.0], [3.0]]))
    # Fisher (1.25, .25, 2), mean 7/6; the importance is .5 times Fisher / mean.
    first = 0.5 * np.array([1.25, 0.25, 2]) * 6 / 7
    np.testing.assert_allclose(agent._stored["importance"], first)
    end_task(agent, np.zeros(3), np.array([[0.0]]))
    # Fisher (0, 1, 2), mean 1.
    np.testing.assert_allclose(agent._stored["importance"], 0.5 * (first + np.arange(3)))
    gap = np.array([0.5, -1.0, 2.0])
    np.testing.assert_allclose(agent._penalty().value(gap), np.sum((first + np.arange(3)) * gap**2))


@pytest.mark.parametrize(
    ("size", "steps", "batch", "sampled"),
    [
        (4, 24, 5, [12, 15, 18, 21]),  # every kth of the last half
        (3, 24, 24, [12, 15, 18]),  # an even distance is made odd
        (100, 6, 2, [3, 4, 5]),  # a short task gives what it has
        (0, 10, 5, []),
    ],
)
def test_states_of_the_last_half_are_sampled(size: int, steps: int, batch: int, sampled: list[int]) -> None:
    sample = continual.StateSample(size, steps)
    for start in range(0, steps, batch):
        sample.add(np.arange(start, min(start + batch, steps))[:, None])
    assert sample.observations[:, 0].tolist() == sampled


def random_penalty(architecture: Architecture) -> continual.Divergence:
    rng = np.random.default_rng(5)
    shape = (9, 2)
    old = (0.3 * rng.standard_normal(shape), 0.2 * rng.standard_normal(shape))
    return continual.Divergence(3.0, architecture, rng.standard_normal((9, 3)), *old)


def test_a_divergence_by_hand() -> None:
    # Old N(0, 1) and N(1, 2²); new N(1, 2²) in both states. KL: log 2 + (1 + 1) / 8 − 1/2, and 0.
    old = np.array([[0.0], [1.0]]), np.log([[1.0], [2.0]])
    penalty = continual.Divergence(2.0, LINE, np.ones((2, 1)), *old)
    assert penalty.value(np.array([1.0, 0.0, np.log(2)])) == pytest.approx(np.log(2) - 0.25)


@each_architecture
def test_the_gradient_is_the_derivative(architecture: Architecture) -> None:
    penalty, theta = random_penalty(architecture), random_policy(architecture)
    np.testing.assert_allclose(penalty.gradient(theta), numeric_gradient(penalty.value, theta), 1e-5, 1e-7)


@each_architecture
def test_the_curvature_is_the_second_derivative_where_new_equals_old(architecture: Architecture) -> None:
    theta, inputs = random_policy(architecture), random_penalty(architecture).inputs
    means, log_sigma = mean_and_log_sigma(architecture, theta, inputs)
    penalty = continual.Divergence(3.0, architecture, inputs, means, np.broadcast_to(log_sigma, means.shape))
    assert penalty.value(theta) == pytest.approx(0, abs=1e-12)
    np.testing.assert_allclose(penalty.gradient(theta), 0, atol=1e-12)
    vector = np.random.default_rng(6).standard_normal(len(theta))
    width = 1e-5
    difference = penalty.gradient(theta + width * vector) - penalty.gradient(theta - width * vector)
    product = penalty.curvature(theta).product(vector)
    np.testing.assert_allclose(product, difference / (2 * width), rtol=1e-4, atol=1e-6)


def test_the_states_of_all_tasks_are_stored_with_the_policy_that_learned_them() -> None:
    agent = on_a_line("cloning", 1.0, 0.0, 0.0, 0.0)
    assert agent._penalty() is None
    end_task(agent, np.array([2.0, 0.0, 0.5]), np.array([[1.0], [3.0]]))
    end_task(agent, np.array([0.0, 7.0, -1.0]), np.array([[5.0]]))
    np.testing.assert_allclose(agent._stored["observations"], [[1], [3], [5]])
    np.testing.assert_allclose(agent._stored["means"], [[2], [6], [7]])
    np.testing.assert_allclose(agent._stored["log_sigmas"], [[0.5], [0.5], [-1.0]])


def test_stored_states_are_seen_through_the_present_moments() -> None:
    agent = on_a_line("cloning", 1.0, 0.0, 0.0, 0.0)
    agent._policy_inputs = lambda raw: raw / 2
    end_task(agent, np.array([1.0, 0.0, 0.0]), np.array([[4.0]]))
    agent._policy_inputs = lambda raw: raw / 4
    penalty = agent._penalty()
    # The input was 2 and is 1 now: w = 2 gives the stored mean again.
    assert penalty.value(np.array([2.0, 0.0, 0.0])) == 0
    assert penalty.value(np.array([1.0, 0.0, 0.0])) == 0.5


SIZES = (2, 2, 2, 1)
"""Hidden parameters: 4 weights, 2 biases, 4 weights, 2 biases."""
HIDDEN = np.array([0.1, -0.9, 0.5, 0.2, 9, 9, -4.0, 3.0, 1.0, 2.0, 9, 9])


def test_a_task_keeps_the_largest_weights_of_each_layer_and_leaves_the_others() -> None:
    owners = no_owners(SIZES)
    assert owners.tolist() == [0, 0, 0, 0, -1, -1, 0, 0, 0, 0, -1, -1]
    assert trainable(owners, 1, pruned=False).all()
    owners = claimed(SIZES, owners, HIDDEN, 1, 2)
    assert owners.tolist() == [0, 1, 1, 0, -1, -1, 1, 1, 0, 0, -1, -1]
    # Then it trains its own weights, the next task the free ones, and neither a bias.
    assert np.flatnonzero(trainable(owners, 1, pruned=True)).tolist() == [1, 2, 6, 7]
    assert np.flatnonzero(trainable(owners, 2, pruned=False)).tolist() == [0, 3, 8, 9]


def test_a_task_sees_biases_its_weights_and_those_of_earlier_tasks() -> None:
    owners = claimed(SIZES, no_owners(SIZES), HIDDEN, 1, 2)
    owners = claimed(SIZES, owners, HIDDEN, 2, 3)
    assert owners.tolist() == [0, 1, 1, 2, -1, -1, 1, 1, 0, 2, -1, -1]
    assert np.flatnonzero(visible(owners, 1)).tolist() == [1, 2, 4, 5, 6, 7, 10, 11]
    assert np.flatnonzero(visible(owners, 2)).tolist() == [1, 2, 3, 4, 5, 6, 7, 9, 10, 11]
