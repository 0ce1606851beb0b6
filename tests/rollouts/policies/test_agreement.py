"""The difference between recorded actions and those of a policy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gym_extensions.errors import BenchError
from gym_extensions.rollouts.policies.agreement import TOLERANCE, differences

from .examples import SEEN, SMALL, TASKED

BOX = (np.full(1, -0.5), np.full(1, 0.5))


def test_clipped_actions_of_the_policy_agree() -> None:
    actions = np.clip(SMALL.act(SEEN), *BOX)
    assert differences(SMALL, SEEN, actions, BOX).max() <= 1e-6 < TOLERANCE


def test_another_action_differs_in_half_widths_of_the_action_space() -> None:
    actions = np.clip(SMALL.act(SEEN), *BOX)
    inside = int(np.argmin(np.abs(actions)))
    actions[inside] += 0.1
    apart = differences(SMALL, SEEN, actions, BOX)
    assert apart[inside] == pytest.approx(0.2, abs=1e-5)
    assert np.delete(apart, inside).max() <= 1e-6


def test_the_task_selects_the_arrays() -> None:
    actions = np.clip(TASKED.act(SEEN, task=1), *BOX)
    assert differences(TASKED, SEEN, actions, BOX, task=1).max() <= 1e-6
    assert differences(TASKED, SEEN, actions, BOX, task=0).max() > 0.1


def test_a_gaussian_allows_eight_standard_deviations() -> None:
    gaussian = replace(SMALL, head="gaussian", log_sigma=np.full(1, -4.0, np.float32))
    wide = (np.full(1, -9.0), np.full(1, 9.0))
    mean, sigma = SMALL.act(SEEN), np.exp(-4.0)
    assert differences(gaussian, SEEN, gaussian.act(SEEN, np.random.default_rng(0)), wide).max() == 0
    assert differences(gaussian, SEEN, mean + 9 * sigma, wide) == pytest.approx(sigma / 9, abs=1e-5)


def test_a_policy_that_overflows_differs() -> None:
    huge = replace(SMALL, weights=(np.full((2, 1), 3e38, np.float32),), biases=(np.zeros(1, np.float32),))
    states = np.array([[10.0, -10.0]])
    assert differences(huge, states, np.zeros((1, 1)), BOX).tolist() == [np.inf]


def test_actions_of_another_size_are_reported() -> None:
    with pytest.raises(BenchError, match="The actions have 3 values; the policy has 1"):
        differences(SMALL, SEEN, np.zeros((40, 3)), BOX)
