"""The policy of a TRPO agent as the plain arrays of a submission."""

from __future__ import annotations

from typing import Any

from gym_extensions.baselines.agent import Array
from gym_extensions.baselines.trpo.gaussian_policy import Architecture
from gym_extensions.baselines.trpo.mlp import layers
from gym_extensions.baselines.trpo.normalization import CLIP, Moments, scale
from gym_extensions.rollouts.policies import Policy


def exported(
    architecture: Architecture,
    theta: Array,
    moments: Moments,
    box: tuple[Array, Array],
    *,
    deterministic: bool,
) -> Policy:
    """The policy of the parameters; its actions equal the agent's bit for bit on batches of the same size.

    Args:
        architecture: the network of the mean.
        theta: the parameters, log σ last.
        moments: of the observations; those of no observations normalize nothing.
        box: middle and half width of the action space, (a,) each.
        deterministic: whether the action is the mean or a sample.
    """
    network = layers(architecture.sizes, theta)
    normalization: dict[str, Any] = {}
    if moments.count:
        normalization = {
            "observation_mean": moments.mean,
            "observation_scale": scale(moments),
            "observation_clip": CLIP,
        }
    return Policy(
        action_offset=box[0].ravel(),
        action_scale=box[1].ravel(),
        weights=tuple(weights for weights, _ in network),
        biases=tuple(bias for _, bias in network),
        activation=architecture.activation,
        output_activation="tanh" if architecture.tanh_mean else "linear",
        head="deterministic" if deterministic else "gaussian",
        log_sigma=theta[-architecture.sizes[-1] :],
        **normalization,
    )
