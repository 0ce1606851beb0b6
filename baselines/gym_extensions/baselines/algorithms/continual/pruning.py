"""PackNet's masks: which task owns a weight of the hidden layers (Mallya and Lazebnik 2018).

As in Wolczyk et al. 2021 the masks cover the hidden layers' weight matrices, layer by layer. Biases are
shared and frozen after the first task. The output layer and log σ belong to one task each.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from gym_extensions.baselines.agent import Array
from gym_extensions.baselines.trpo.mlp import Sizes

FREE, BIAS = 0, -1
"""Owners that are not tasks: a weight that the next task may train, and a bias. Tasks count from 1."""


def no_owners(sizes: Sizes) -> Array:
    """The owner of every parameter of the hidden layers before the first task, int16 (h,)."""
    parts = []
    for fan_in, fan_out in pairwise(sizes[:-1]):
        parts += [np.full(fan_in * fan_out, FREE), np.full(fan_out, BIAS)]
    return np.concatenate(parts).astype(np.int16)


def claimed(sizes: Sizes, owners: Array, hidden: Array, number: int, share: float) -> Array:
    """The owners after a task: in each layer it keeps the given share of the free weights, the largest ones.

    Args:
        sizes: widths of the network's layers.
        owners: of the hidden layers' parameters (h,).
        hidden: the hidden layers' parameters (h,).
        number: of the task, from 1.
        share: of the free weights, in (0, 1].

    Example:
        >>> weights = np.array([0.1, -0.5, 0.3, 0.2, 0.0, 0.0])
        >>> claimed((2, 2, 1), no_owners((2, 2, 1)), weights, 1, 0.5).tolist()
        [0, 1, 1, 0, -1, -1]
    """
    new, start = owners.copy(), 0
    for fan_in, fan_out in pairwise(sizes[:-1]):
        end = start + fan_in * fan_out
        free = start + np.flatnonzero(owners[start:end] == FREE)
        largest_first = free[np.argsort(-np.abs(hidden[free]), kind="stable")]
        new[largest_first[: round(share * len(free))]] = number
        start = end + fan_out
    return new


def trainable(owners: Array, number: int, pruned: bool) -> Array:
    """True for the hidden layers' parameters that a task may change (h,).

    Before it prunes, a task trains the free weights; after, its own. The first task trains the biases until
    it prunes.
    """
    before = (owners == FREE) | ((owners == BIAS) & (number == 1))
    mask: Array = owners == number if pruned else before
    return mask


def visible(owners: Array, number: int) -> Array:
    """True for the hidden layers' parameters that a finished task uses (h,). The others count as 0.

    It uses the biases, its own weights and those of earlier tasks.
    """
    mask: Array = (owners != FREE) & (owners <= number)
    return mask
