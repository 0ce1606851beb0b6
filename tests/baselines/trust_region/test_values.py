"""Advantages by hand, where truncation is bootstrapped and termination is not, and the value function."""

import numpy as np
import pytest

from gym_extensions.baselines.agent import Array
from gym_extensions.baselines.trust_region.values import ValueFit, ValueFunction, advantages


def column(*values: float) -> Array:
    return np.array(values)[:, None]


def flags(*values: int) -> Array:
    return np.array(values, bool)[:, None]


CASES = [
    # Discount .5, λ .5; rewards 1, 2; values 4, 2, 8.
    # Second: 2 + .5·8 − 2 = 4; first: 1 + .5·2 − 4 + .25·4 = −1.
    ("unfinished", flags(0, 0), flags(0, 0), [-1.0, 4.0]),
    # The last step terminates: 2 − 2 = 0; first: −2 + .25·0.
    ("terminated", flags(0, 1), flags(0, 0), [-2.0, 0.0]),
    # The time limit is bootstrapped with the next state's value, as an unfinished episode is.
    ("truncated", flags(0, 0), flags(0, 1), [-1.0, 4.0]),
    # The first step is truncated: it takes its next state's value, and nothing from after the reset.
    ("truncated first", flags(0, 0), flags(1, 0), [-2.0, 4.0]),
    ("terminated first", flags(1, 0), flags(0, 0), [-3.0, 4.0]),
]


@pytest.mark.parametrize(
    ("terminated", "truncated", "expected"), [case[1:] for case in CASES], ids=[case[0] for case in CASES]
)
def test_advantages_by_hand(terminated: Array, truncated: Array, expected: list[float]) -> None:
    values = advantages(column(1, 2), column(4, 2, 8), terminated, truncated, discount=0.5, gae_lambda=0.5)
    assert values.ravel().tolist() == expected


def test_with_lambda_one_the_advantage_is_the_discounted_return_minus_the_value() -> None:
    rewards, values = np.arange(5.0)[:, None], np.arange(6.0)[::-1, None] ** 2
    never = np.zeros((5, 1), bool)
    estimates = advantages(rewards, values, never, never, discount=0.9, gae_lambda=1.0)
    returns = [sum(0.9 ** (k - t) * k for k in range(t, 5)) + 0.9 ** (5 - t) * values[5, 0] for t in range(5)]
    np.testing.assert_allclose(estimates.ravel(), np.array(returns) - values[:5, 0])


def test_environments_do_not_mix() -> None:
    rng = np.random.default_rng(0)
    rewards, values = rng.standard_normal((6, 3)), rng.standard_normal((7, 3))
    terminated, truncated = rng.random((2, 6, 3)) < 0.3
    together = advantages(rewards, values, terminated, truncated, discount=0.9, gae_lambda=0.8)
    for env in range(3):
        rows = (slice(None), slice(env, env + 1))
        alone = advantages(
            rewards[rows], values[rows], terminated[rows], truncated[rows], discount=0.9, gae_lambda=0.8
        )
        np.testing.assert_array_equal(together[rows], alone)


def make(seed: int = 0) -> ValueFunction:
    return ValueFunction(2, np.random.default_rng(seed), ValueFit())


@pytest.mark.parametrize("scale", [1.0, 1e4])
def test_it_fits_a_smooth_function_of_any_scale(scale: float) -> None:
    rng, value = np.random.default_rng(0), make()
    observations = rng.standard_normal((2000, 2)) * [1, 100]
    targets = scale * (3 + np.sin(observations[:, 0]) + observations[:, 1] / 100)
    for _ in range(5):
        value.fit(observations, targets, rng)
    error = value.predict(observations) - targets
    assert np.var(error) < 0.02 * np.var(targets)


def test_new_scales_of_targets_leave_every_prediction_as_it_was() -> None:
    rng, value = np.random.default_rng(0), make()
    observations = rng.standard_normal((300, 2))
    value.fit(observations, rng.standard_normal(300), rng)
    before = value.predict(observations)
    value._rescale(np.array([5_000.0, 9_000.0]))
    np.testing.assert_allclose(value.predict(observations), before, atol=0.02)
    assert value.state["level"].tolist() == [7_000.0, 2_000.0]


def test_the_number_of_adam_steps_is_epochs_times_minibatches() -> None:
    rng = np.random.default_rng(0)
    observations, targets = rng.standard_normal((1000, 2)), rng.standard_normal(1000)
    value = ValueFunction(2, rng, ValueFit(epochs=3, minibatches=4, smallest_minibatch=10))
    value.fit(observations, targets, rng)
    assert value.state["updates"].tolist() == [12]
