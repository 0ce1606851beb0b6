"""A policy with an output layer per task as the plain arrays of a submission."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gym_extensions.baselines.agent import Array
from gym_extensions.baselines.algorithms.continual.heads import Head, Heads
from gym_extensions.baselines.trpo.export import exported
from gym_extensions.baselines.trpo.gaussian_policy import Architecture
from gym_extensions.baselines.trpo.mlp import layers
from gym_extensions.baselines.trpo.normalization import scale
from gym_extensions.rollouts.policies import Policy


def head_rows(heads: Heads, present: int) -> list[Head]:
    """The head of every task up to the last learned one; the present task's for those not learned yet.

    A policy uses its last row for all later tasks, so the present task's head is added if it is not the last.
    """
    rows = [heads.get(task, heads[present]) for task in range(max(heads) + 1)]
    return rows if rows[-1] is heads[present] else [*rows, heads[present]]


def exported_heads(
    architecture: Architecture,
    hidden: Array,
    rows: Sequence[Head],
    box: tuple[Array, Array],
    *,
    deterministic: bool,
    masks: Sequence[Array] | None = None,
) -> Policy:
    """The policy with a row per head; its actions equal the agent's.

    Args:
        architecture: the policy's network.
        hidden: the parameters of the hidden layers, which all rows share (h,).
        rows: the heads.
        box: middle and half width of the action space, (a,) each.
        deterministic: whether the action is the mean or a sample.
        masks: True for the hidden parameters that each row uses (h,); by default it uses all.
    """
    whole = [np.concatenate([hidden, row.parameters]) for row in rows]
    policy = exported(architecture, whole[0], rows[0].moments, box, deterministic=deterministic)
    outputs = [layers(architecture.sizes, theta)[-1] for theta in whole]
    policy = replace(
        policy,
        weights=(*policy.weights[:-1], np.stack([weights for weights, _ in outputs])),
        biases=(*policy.biases[:-1], np.stack([bias for _, bias in outputs])),
        log_sigma=np.stack([theta[-architecture.sizes[-1] :] for theta in whole]),
    )
    if policy.observation_mean is not None:
        means, scales = [row.moments.mean for row in rows], [scale(row.moments) for row in rows]
        policy = replace(policy, observation_mean=np.stack(means), observation_scale=np.stack(scales))
    if masks is None:
        return policy
    views = [[weights for weights, _ in layers(architecture.sizes[:-1], mask)] for mask in masks]
    return replace(policy, masks=(*(np.stack(layer) for layer in zip(*views, strict=True)), None))
