"""PackNet on TRPO: prune, freeze, retrain (Mallya and Lazebnik 2018; Wolczyk et al. 2021)."""

from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from gym_extensions.baselines.agent import Array, Card
from gym_extensions.baselines.algorithms.multi_head import Head, MultiHead
from gym_extensions.baselines.trust_region import policy, values
from gym_extensions.submissions.policies.mlp import Policy

RETRAIN_SHARE = 0.2  # this project; Wolczyk et al. 2021 retrain on stored transitions instead
FREE, BIAS = 0, -1
"""Owners that are not tasks: a weight that the next task may train, and a bias. Tasks count from 1."""


def no_owners(sizes: policy.Sizes) -> Array:
    """The owner of every parameter of the hidden layers before the first task, int16 (h,)."""
    parts = [np.zeros(0)]  # all, if no layer is hidden
    for fan_in, fan_out in pairwise(sizes[:-1]):
        parts += [np.full(fan_in * fan_out, FREE), np.full(fan_out, BIAS)]
    return np.concatenate(parts).astype(np.int16)


def claimed(sizes: policy.Sizes, owners: Array, hidden: Array, number: int, num_tasks: int) -> Array:
    """The owners after task k of N: of the free weights in each layer, it keeps the largest 1 / (N − k + 1).

    ``owners`` and ``hidden`` are of the hidden layers' parameters (h,); ``number``, k, counts from 1.

    Example:
        >>> weights = np.array([0.1, -0.5, 0.3, 0.2, 0.0, 0.0])
        >>> claimed((2, 2, 1), no_owners((2, 2, 1)), weights, 1, 2).tolist()
        [0, 1, 1, 0, -1, -1]
    """
    new, start, share = owners.copy(), 0, 1 / (num_tasks - number + 1)
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
    return owners == number if pruned else before


def visible(owners: Array, number: int) -> Array:
    """True for the hidden layers' parameters that a finished task uses (h,). The others count as 0.

    It uses the biases, its own weights and those of earlier tasks.
    """
    return (owners != FREE) & (owners <= number)


class PackNet(MultiHead):
    """The agent ``packnet``.

    Of N tasks, task k trains the free weights, keeps the largest 1 / (N − k + 1) of them in each hidden
    layer, sets the others to 0, and trains what it keeps for the last share of its budget. Later tasks use
    these weights and do not change them, so the policy of a finished task never changes.
    """

    name, title = "packnet", "TRPO + PackNet"
    description = "The reference agent with PackNet: tasks own weights and a head; it observes the task."
    parent = ""  # the first task's weights are pruned, so no stage is equal to that of trpo

    def __init__(self, *arguments: Any, retrain_share: float = RETRAIN_SHARE, **settings: Any) -> None:
        """``retrain_share`` is the share of a task's budget after it pruned."""
        super().__init__(*arguments, **settings)
        self._retrain_share = retrain_share
        self._owners = no_owners(self._architecture.sizes)
        self._pruned = False

    def _train(self, collector: values.Collector, steps: int) -> int:
        self._pruned = False
        is_last = self._number == self._num_tasks
        batches = 0 if is_last else round(self._retrain_share * steps / self._batch_steps)
        first = max(steps - batches * self._batch_steps, self._batch_steps)
        taken = super()._train(collector, first)
        hidden, sizes = self._theta[self._hidden], self._architecture.sizes
        self._owners = claimed(sizes, self._owners, hidden, self._number, self._num_tasks)
        self._theta = np.concatenate([np.where(self._owners == FREE, 0, hidden), self._theta[self._head]])
        self._pruned = True
        early = (taken - first) // self._batch_steps * self._batch_steps  # whole batches of the second part
        return taken + super()._train(collector, steps - first - early)

    def _trainable(self) -> Array:
        mask = np.ones_like(self._theta)
        mask[self._hidden] = trainable(self._owners, self._number, self._pruned)
        return mask

    def _parameters_of(self, head: Head) -> Array:
        hidden = np.where(visible(self._owners, head.number), self._theta[self._hidden], 0)
        return np.concatenate([hidden.astype(self._theta.dtype), head.parameters])

    def _policy_of(self, head: Head) -> Policy:
        layers = policy.layers(self._architecture.sizes[:-1], visible(self._owners, head.number))
        return replace(super()._policy_of(head), masks=(*(weights for weights, _ in layers), None))

    def card(self) -> Card:
        """The card of ``multi-head`` with the share of a task's budget after pruning."""
        card = super().card()
        return replace(card, hyperparameters={**card.hyperparameters, "retrain_share": self._retrain_share})

    def _state(self) -> dict[str, Array]:
        return super()._state() | {"owners": self._owners}

    def _restore(self, arrays: Mapping[str, Array]) -> None:
        super()._restore(arrays)
        self._owners = arrays["owners"]


make = PackNet
