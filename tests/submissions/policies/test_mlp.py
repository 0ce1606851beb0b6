"""A policy's actions, worked by hand."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from gym_extensions.errors import BenchError
from gym_extensions.submissions.policies.mlp import Policy, by_task

SEEN = np.random.default_rng(0).standard_normal((40, 2))
SMALL = Policy(
    action_offset=np.zeros(1, np.float32),
    action_scale=np.ones(1, np.float32),
    weights=(np.array([[0.5, -1.0, 2.0], [1.0, 0.0, 0.5]], np.float32), np.ones((3, 1), np.float32)),
    biases=(np.zeros(3, np.float32), np.full(1, 0.125, np.float32)),
    activation="tanh",
    log_sigma=np.full(1, -1.0, np.float32),
)
TASKED = Policy(
    action_offset=np.zeros(1),
    action_scale=np.ones(1),
    weights=(np.array([[[1.0], [1.0]], [[1.0], [-1.0]]]),),
    biases=(np.zeros(1),),
    masks=(np.array([[[True], [True]], [[True], [False]]]),),
)
"""Two rows of tasks: the sum of the observations, and the first of them."""


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
    assert len(repr(policy)) < 100


def test_the_mean_and_the_sample_are_squashed_separately() -> None:
    mean = np.full((1, 1), 2.0)
    policy = Policy(np.zeros(1), np.ones(1), weights=(np.ones((1, 1)),), biases=(np.zeros(1),))
    before = replace(policy, output_activation="tanh", head="gaussian", log_sigma=np.zeros(1))
    after = replace(policy, squash="tanh", head="gaussian", log_sigma=np.zeros(1))
    noise = np.random.default_rng(5).standard_normal((1, 1))
    np.testing.assert_allclose(before.act(mean, np.random.default_rng(5)), np.tanh(2.0) + noise)
    np.testing.assert_allclose(after.act(mean, np.random.default_rng(5)), np.tanh(2.0 + noise))


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


def stage(seed: int) -> Policy:
    """A policy with masks and normalized observations."""
    rng = np.random.default_rng(seed)
    return Policy(
        action_offset=np.zeros(2),
        action_scale=np.ones(2),
        weights=(rng.standard_normal((3, 4)), rng.standard_normal((4, 2))),
        biases=(rng.standard_normal(4), rng.standard_normal(2)),
        masks=(rng.random((3, 4)) < 0.5, None),
        activation="tanh",
        observation_mean=rng.standard_normal(3),
        observation_scale=np.full(3, 1.0 + seed),
    )


def test_policies_by_task_act_as_each_of_them_bit_by_bit_and_later_tasks_as_the_last() -> None:
    observations = np.random.default_rng(9).standard_normal((20, 3))
    policies = [stage(seed) for seed in range(3)]
    for task, each in enumerate([*policies, policies[-1]]):
        assert np.array_equal(by_task(policies).act(observations, task=task), each.act(observations))
    bare = [replace(each, observation_mean=None, observation_scale=None) for each in policies]
    assert by_task(bare).observation_mean is None


def test_later_changes_of_the_agents_arrays_do_not_change_the_policy() -> None:
    weights = np.ones((2, 1))
    policy = replace(SMALL, weights=(weights,), biases=(np.zeros(1),))
    weights[:] = np.nan
    assert policy.act(np.ones((1, 2))).tolist() == [[2.0]]


@pytest.mark.parametrize(
    ("call", "fact"),
    [
        (lambda: replace(SMALL, head="gaussian").act(SEEN), "The policy samples"),
        (lambda: SMALL.act(np.zeros((1, 5))), "5 values; the policy has 2 inputs"),
        (lambda: replace(SMALL, activation="swish"), "'activation' is 'swish'"),
        (lambda: replace(SMALL, masks=(*(None for _ in SMALL.weights), None)), "3 masks for 2 layers"),
    ],
)
def test_what_cannot_be_done_is_reported(call: Any, fact: str) -> None:
    with pytest.raises(BenchError, match=fact):
        call()


def test_tensors_that_are_trained_or_in_bfloat16_become_arrays() -> None:
    torch = pytest.importorskip("torch")
    weight = torch.nn.Parameter(torch.ones(2, 1, dtype=torch.bfloat16))
    policy = Policy(torch.zeros(1), torch.ones(1), weights=(weight,), biases=(torch.zeros(1),))
    assert policy.act(np.array([[2.0, 3.0]])).tolist() == [[5.0]]
