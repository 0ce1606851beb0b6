"""A policy's actions, worked by hand, and its file."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

import numpy as np
import pytest

from gym_extensions.errors import BenchError
from gym_extensions.rollouts.policies import Policy
from gym_extensions.rollouts.policies.activations import ACTIVATIONS
from gym_extensions.rollouts.policies.keys import KEYS, LAYER_FIELDS

from .examples import SEEN, SMALL, TASKED


def test_a_network_of_two_layers() -> None:
    policy = Policy(
        action_offset=np.array([1.0]),
        action_scale=np.array([10.0]),
        weights=(np.array([[1.0, -1.0], [0.0, 2.0]]), np.array([[1.0], [3.0]])),
        biases=(np.array([0.5, -1.0]), np.array([0.25])),
        activation="relu",
    )
    # Hidden: relu(2 + .5, −2 + 6 − 1) = 2.5, 3; output 2.5 + 9 + .25.
    assert policy.act(np.array([[2.0, 3.0]])).tolist() == [[1 + 10 * 11.75]]


def test_observations_are_normalized_and_clipped() -> None:
    policy = replace(
        TASKED,
        masks=(),
        observation_mean=np.array([1.0, 2.0]),
        observation_scale=np.array([2.0, 0.5]),
        observation_clip=3.0,
    )
    # (5 − 1) / 2 = 2; (10 − 2) / .5 = 16, clipped to 3. Row 0 of the weights is the sum.
    assert policy.act(np.array([[5.0, 10.0]])).tolist() == [[5.0]]


def test_without_layers_the_action_is_constant_for_every_observation() -> None:
    policy = Policy(np.array([0.5, -1.0], np.float32), np.ones(2, np.float32))
    assert policy.act(np.zeros((3, 7))).tolist() == [[0.5, -1.0]] * 3
    assert policy.num_inputs is None


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("linear", [-2.0, 0.0, 2.0]),
        ("tanh", [-0.9640275801, 0.0, 0.9640275801]),
        ("relu", [0.0, 0.0, 2.0]),
        ("leaky_relu", [-0.02, 0.0, 2.0]),
        ("elu", [-0.8646647168, 0.0, 2.0]),  # e⁻² − 1
        ("silu", [-0.2384058440, 0.0, 1.7615941560]),  # ± 2 / (1 + e^∓2)
    ],
)
def test_each_activation(name: str, expected: list[float]) -> None:
    np.testing.assert_allclose(ACTIVATIONS[name](np.array([-2.0, 0.0, 2.0])), expected, atol=1e-10)
    assert ACTIVATIONS[name](np.ones(1, np.float32)).dtype == np.float32


def test_the_mean_and_the_sample_are_squashed_separately() -> None:
    mean = np.full((1, 1), 2.0)
    policy = Policy(np.zeros(1), np.ones(1), weights=(np.ones((1, 1)),), biases=(np.zeros(1),))
    before = replace(policy, output_activation="tanh", head="gaussian", log_sigma=np.zeros(1))
    after = replace(policy, squash="tanh", head="gaussian", log_sigma=np.zeros(1))
    noise = np.random.default_rng(5).standard_normal((1, 1))
    assert before.act(mean, np.random.default_rng(5)) == np.tanh(2.0) + noise
    assert after.act(mean, np.random.default_rng(5)) == np.tanh(2.0 + noise)


def test_sigma_may_depend_on_the_observation_within_bounds() -> None:
    policy = replace(
        SMALL,
        head="gaussian",
        weights=(np.zeros((2, 1), np.float32),),
        biases=(np.zeros(1, np.float32),),
        log_sigma=np.array([0.5], np.float32),
        log_sigma_weight=np.array([[1.0], [0.0]], np.float32),
        log_sigma_clip=np.array([-2.0, 1.0], np.float32),
    )
    states = np.array([[-1.0, 0.0], [-9.0, 0.0], [9.0, 0.0]]).repeat(20_000, axis=0)
    actions = policy.act(states, np.random.default_rng(0)).reshape(3, -1)
    np.testing.assert_allclose(actions.std(axis=1), np.exp([-0.5, -2.0, 1.0]), rtol=0.02)


def test_a_uniform_policy_fills_the_range() -> None:
    policy = Policy(np.array([1.0]), np.array([2.0]), head="uniform")
    actions = policy.act(np.zeros((20_000, 3)), np.random.default_rng(0))
    assert (actions.min(), actions.max()) == pytest.approx((-1.0, 3.0), abs=0.01)
    assert actions.mean() == pytest.approx(1.0, abs=0.05)


def test_arrays_per_task_and_masks() -> None:
    state = np.array([[1.0, 10.0]])
    # Row 0 sums; row 1 is the difference, and its mask leaves out the second observation.
    assert [TASKED.act(state, task=task).item() for task in (0, 1, 2)] == [11.0, 1.0, 1.0]
    assert (TASKED.num_tasks, SMALL.num_tasks) == (2, 0)


@pytest.mark.parametrize("policy", [SMALL, TASKED, Policy(np.zeros(1), np.ones(1), head="uniform")])
def test_a_file_gives_the_same_policy_and_equal_policies_the_same_bytes(policy: Policy) -> None:
    data = policy.to_bytes()
    again = Policy.from_bytes(data)
    assert again.to_bytes() == replace(policy).to_bytes() == data
    rngs = (np.random.default_rng(1), np.random.default_rng(1))
    assert np.array_equal(policy.act(SEEN, rngs[0]), again.act(SEEN, rngs[1]))


def test_later_changes_of_the_agents_arrays_do_not_change_the_policy() -> None:
    weights = np.ones((2, 1))
    policy = replace(SMALL, weights=(weights,), biases=(np.zeros(1),))
    weights[:] = np.nan
    assert policy.act(np.ones((1, 2))).tolist() == [[2.0]]


def test_every_field_is_an_array_of_the_file() -> None:
    names = {LAYER_FIELDS.get(field.name, field.name) for field in fields(Policy)}
    assert names | {"format"} == set(KEYS)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: replace(SMALL, head="gaussian").act(SEEN),
            "act(): The policy samples. Pass rng, a numpy Generator.",
        ),
        (
            lambda: SMALL.act(np.zeros((1, 5))),
            "act(): The observations have 5 values; the policy has 2 inputs. Use a policy of the same group.",
        ),
        (
            lambda: replace(SMALL, activation="swish"),
            "policy(): 'activation' is 'swish'; expected one of linear, tanh, relu, leaky_relu, elu, silu. "
            "docs/rollout-log.md lists the arrays of a policy.",
        ),
        (
            lambda: replace(SMALL, masks=(*(None for _ in SMALL.weights), None)),
            f"policy(): {len(SMALL.weights) + 1} masks for {len(SMALL.weights)} layers; expected one per "
            "layer, or none. docs/rollout-log.md lists the arrays of a policy.",
        ),
        (
            lambda: Policy.from_bytes(b"not a zip"),
            "The file cannot be read. docs/rollout-log.md lists the arrays of a policy.",
        ),
    ],
)
def test_what_cannot_be_done_is_reported(call: Any, message: str) -> None:
    with pytest.raises(BenchError) as error:
        call()
    assert str(error.value) == message
