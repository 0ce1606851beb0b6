"""Whether recorded actions are those of a policy."""

from __future__ import annotations

import numpy as np

from gym_extensions.errors import BenchError
from gym_extensions.rollouts.policies.activations import Array
from gym_extensions.rollouts.policies.policy import Policy

TOLERANCE = 1e-4
"""Largest difference between a recorded action and the policy's, in half widths of the action space.

Other batch sizes, processors and libraries change the action of a policy by rounding, and so do the rounding
errors of replayed observations (docs/adr/0061 has measurements).
"""


def differences(
    policy: Policy, observations: Array, actions: Array, box: tuple[Array, Array], task: int = 0
) -> Array:
    """How far each recorded action is from what the policy can do (n,), in half widths of the action space.

    For a deterministic policy that is its action. For a Gaussian it is every action within eight standard
    deviations of the mean, and for a uniform policy its whole range: for these, agreement does not show that
    the actions were drawn at random.

    Args:
        policy: the policy.
        observations: (n, …).
        actions: (n, …), as recorded, after clipping.
        box: lowest and highest action.
        task: index of the task in the group.

    Returns:
        The largest difference over the components of each action; infinite where the policy gives NaN.

    Raises:
        BenchError: the observations or the actions have other sizes than the policy's.
    """
    recorded = actions.reshape(len(actions), -1)
    if recorded.shape[1] != len(policy.action_offset):
        message = f"The actions have {recorded.shape[1]} values; the policy has {len(policy.action_offset)}."
        raise BenchError("bad-actions", message, hint="Use a policy of the same group.")
    low, high = (np.asarray(bound, np.float64).ravel() for bound in box)
    with np.errstate(all="ignore"):
        bounds = policy.interval(observations, task)
        lower, upper = (np.clip(bound.astype(np.float64), low, high) for bound in bounds)
        excess = np.maximum(lower - recorded, recorded - upper) / ((high - low) / 2)
    result: Array = np.where(np.isnan(excess), np.inf, np.maximum(excess, 0)).max(axis=1)
    return result
