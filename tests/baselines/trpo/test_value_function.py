"""The value function: fitting, rescaling of targets, and number of steps."""

from __future__ import annotations

import numpy as np
import pytest

from gym_extensions.baselines.trpo.values import ValueFit, ValueFunction


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
