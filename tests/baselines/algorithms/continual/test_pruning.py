"""Who owns a weight: shares and masks by hand."""

from __future__ import annotations

import numpy as np

from gym_extensions.baselines.algorithms.packnet import (
    claimed,
    no_owners,
    trainable,
    visible,
)

SIZES = (2, 2, 2, 1)
"""Hidden parameters: 4 weights, 2 biases, 4 weights, 2 biases."""
HIDDEN = np.array([0.1, -0.9, 0.5, 0.2, 9, 9, -4.0, 3.0, 1.0, 2.0, 9, 9])


def test_before_the_first_task_the_weights_are_free_and_all_can_be_trained() -> None:
    owners = no_owners(SIZES)
    assert owners.tolist() == [0, 0, 0, 0, -1, -1, 0, 0, 0, 0, -1, -1]
    assert trainable(owners, 1, pruned=False).all()


def test_a_task_keeps_the_largest_weights_of_each_layer() -> None:
    owners = claimed(SIZES, no_owners(SIZES), HIDDEN, 1, 0.5)
    assert owners.tolist() == [0, 1, 1, 0, -1, -1, 1, 1, 0, 0, -1, -1]


def test_a_pruned_task_trains_its_own_weights_and_no_bias() -> None:
    owners = claimed(SIZES, no_owners(SIZES), HIDDEN, 1, 0.5)
    assert np.flatnonzero(trainable(owners, 1, pruned=True)).tolist() == [1, 2, 6, 7]


def test_the_next_task_trains_the_free_weights_and_no_bias() -> None:
    owners = claimed(SIZES, no_owners(SIZES), HIDDEN, 1, 0.5)
    assert np.flatnonzero(trainable(owners, 2, pruned=False)).tolist() == [0, 3, 8, 9]


def test_a_task_sees_biases_its_weights_and_those_of_earlier_tasks() -> None:
    owners = claimed(SIZES, no_owners(SIZES), HIDDEN, 1, 0.5)
    owners = claimed(SIZES, owners, HIDDEN, 2, 0.5)
    assert owners.tolist() == [0, 1, 1, 2, -1, -1, 1, 1, 0, 2, -1, -1]
    assert np.flatnonzero(visible(owners, 1)).tolist() == [1, 2, 4, 5, 6, 7, 10, 11]
    assert np.flatnonzero(visible(owners, 2)).tolist() == [1, 2, 3, 4, 5, 6, 7, 9, 10, 11]


def test_equal_shares_leave_nothing_after_the_last_task() -> None:
    owners = no_owners((4, 6, 1))
    hidden = np.random.default_rng(0).standard_normal(30)
    for number, share in ((1, 1 / 3), (2, 1 / 2), (3, 1.0)):
        owners = claimed((4, 6, 1), owners, hidden, number, share)
        assert np.count_nonzero(owners == number) == 8
    assert not (owners == 0).any()
