"""The divergence from earlier policies in stored states, its derivatives, and what is stored."""

from __future__ import annotations

import numpy as np
import pytest

from gym_extensions.baselines.algorithms.cloning import Divergence
from gym_extensions.baselines.trpo.policy import Architecture, mean_and_log_sigma

from ...trpo.policies import ARCHITECTURES, numeric_gradient, random_policy
from .goals import LINE, end_task, on_a_line

each_architecture = pytest.mark.parametrize("architecture", ARCHITECTURES, ids=["linear", "tanh"])


def random_penalty(architecture: Architecture) -> Divergence:
    rng = np.random.default_rng(5)
    shape = (9, 2)
    old = (0.3 * rng.standard_normal(shape), 0.2 * rng.standard_normal(shape))
    return Divergence(3.0, architecture, rng.standard_normal((9, 3)), *old)


def test_a_divergence_by_hand() -> None:
    # Old N(0, 1) and N(1, 2²); new N(1, 2²) in both states. KL: log 2 + (1 + 1) / 8 − 1/2, and 0.
    penalty = Divergence(
        2.0, LINE, np.array([[1.0], [1.0]]), np.array([[0.0], [1.0]]), np.log([[1.0], [2.0]])
    )
    assert penalty.value(np.array([1.0, 0.0, np.log(2)])) == pytest.approx(np.log(2) - 0.25)


@each_architecture
def test_the_gradient_is_the_derivative(architecture: Architecture) -> None:
    penalty, theta = random_penalty(architecture), random_policy(architecture)
    np.testing.assert_allclose(
        penalty.gradient(theta), numeric_gradient(penalty.value, theta), rtol=1e-5, atol=1e-7
    )


@each_architecture
def test_the_curvature_is_the_second_derivative_where_new_equals_old(architecture: Architecture) -> None:
    theta, inputs = random_policy(architecture), random_penalty(architecture).inputs
    means, log_sigma = mean_and_log_sigma(architecture, theta, inputs)
    penalty = Divergence(3.0, architecture, inputs, means, np.broadcast_to(log_sigma, means.shape))
    assert penalty.value(theta) == pytest.approx(0, abs=1e-12)
    np.testing.assert_allclose(penalty.gradient(theta), 0, atol=1e-12)
    vector = np.random.default_rng(6).standard_normal(len(theta))
    width = 1e-5
    difference = penalty.gradient(theta + width * vector) - penalty.gradient(theta - width * vector)
    np.testing.assert_allclose(
        penalty.curvature(theta).product(vector), difference / (2 * width), rtol=1e-4, atol=1e-6
    )


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
