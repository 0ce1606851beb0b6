"""The network of a policy: from observations to the mean and log σ."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gym_extensions.errors import BenchError
from gym_extensions.rollouts.policies.activations import ACTIVATIONS, Array

if TYPE_CHECKING:
    from gym_extensions.rollouts.policies.policy import Policy


def mean_and_log_sigma(policy: Policy, observations: Array, task: int = 0) -> tuple[Array, Array]:
    """The mean before ``squash`` (n, a) and log σ, (a,) or (n, a); log σ is 0 if it is not stated.

    Args:
        policy: the policy.
        observations: (n, …).
        task: index of the task in the group.

    Raises:
        BenchError: the observations have another size than the policy's inputs.
    """
    hidden = _normalized(policy, np.asarray(observations, policy.observation_dtype), task)
    output = np.zeros((len(hidden), len(policy.action_offset)), policy.action_offset.dtype)
    last = len(policy.weights) - 1
    for layer, (weights, biases) in enumerate(zip(policy.weights, policy.biases, strict=True)):
        weight = _row(weights, 2, task)
        mask = policy.masks[layer] if policy.masks else None
        weight = weight if mask is None else weight * _row(mask, 2, task)
        values = hidden @ weight + _row(biases, 1, task)
        if layer == last:
            output = values
        else:
            hidden = ACTIVATIONS[policy.activation](values)
    return ACTIVATIONS[policy.output_activation](output), _log_sigma(policy, hidden, task)


def to_action(policy: Policy, values: Array) -> Array:
    """Actions (n, a) from the values of the head, not clipped to the action space."""
    actions: Array = policy.action_offset + policy.action_scale * ACTIVATIONS[policy.squash](values)
    return actions


def _normalized(policy: Policy, observations: Array, task: int) -> Array:
    values = observations.reshape(len(observations), -1)
    inputs = policy.num_inputs
    if inputs not in (None, values.shape[1]):
        message = f"The observations have {values.shape[1]} values; the policy has {inputs} inputs."
        raise BenchError("bad-observations", message, "act()", "Use a policy of the same group.")
    if policy.observation_mean is not None and policy.observation_scale is not None:
        mean, scale = _row(policy.observation_mean, 1, task), _row(policy.observation_scale, 1, task)
        values = (values - mean) / scale
    if policy.observation_clip is not None:
        values = np.clip(values, -policy.observation_clip, policy.observation_clip)
    return values.astype(policy.weights[0].dtype) if policy.weights else values


def _log_sigma(policy: Policy, hidden: Array, task: int) -> Array:
    if policy.log_sigma is None:
        return np.zeros_like(policy.action_offset)
    log_sigma = _row(policy.log_sigma, 1, task)
    if policy.log_sigma_weight is not None:
        log_sigma = hidden @ _row(policy.log_sigma_weight, 2, task) + log_sigma
    return log_sigma if policy.log_sigma_clip is None else np.clip(log_sigma, *policy.log_sigma_clip)


def _row(values: Array, ndim: int, task: int) -> Array:
    """The array of a task: a row of the leading axis, if there is that axis."""
    return values if values.ndim == ndim else values[min(task, len(values) - 1)]
