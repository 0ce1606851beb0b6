"""The policy of a Stable-Baselines3 or SBX model as plain arrays.

Supported are multilayer perceptrons of flat observations: the Gaussian actors of PPO, A2C and TRPO, the
squashed Gaussian actors of SAC and TQC, the deterministic actors of TD3 and DDPG, and the actors of SBX's PPO
and SAC.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from stable_baselines3.common.base_class import BaseAlgorithm

from gym_extensions.baselines.adapters.flax_layers import flax_layers
from gym_extensions.baselines.adapters.torch_layers import policy_layers
from gym_extensions.baselines.agent import Array
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.policies import Policy

LOG_SIGMA_CLIP = np.array([-20.0, 2.0], np.float32)
"""Bounds of log σ of a squashed Gaussian actor, in SB3 and SBX."""
Statistics = tuple[Array, Array, float]
"""Mean and standard deviation of the observations, and the limit of standardized observations."""
Parts = dict[str, Any]


def exported(
    model: BaseAlgorithm, *, deterministic: bool = True, statistics: Statistics | None = None
) -> Policy:
    """The policy of a model, trained by this package or loaded with ``PPO.load``.

    Args:
        model: of Stable-Baselines3, SB3-Contrib or SBX.
        deterministic: whether the policy takes the mean action or samples.
        statistics: of the observations, if the model was trained with normalized ones.

    Raises:
        BenchError: the model's network has no such form.
    """
    if reason := unsupported(model):
        hint = "Use an MlpPolicy without use_sde, or train without storing the policy."
        raise BenchError("unsupported-policy", reason, "policy()", hint)
    parts = _actor_parts(model)(model)
    parts["head"] = "deterministic" if deterministic or "log_sigma" not in parts else "gaussian"
    if statistics is not None:
        names = ("observation_mean", "observation_scale", "observation_clip")
        parts |= dict(zip(names, statistics, strict=True))
    return Policy(**parts)


def unsupported(model: BaseAlgorithm) -> str:
    """Why the policy of a model cannot be expressed as plain arrays; empty if it can."""
    name = f"The policy of {type(model).__name__}, {type(model.policy).__name__},"
    shape = model.observation_space.shape or ()
    if len(shape) != 1:
        return f"{name} does not have flat observations, but observations of shape {shape}."
    if getattr(model, "use_sde", False):
        return f"{name} uses state-dependent exploration (use_sde)."
    try:
        inputs = _actor_parts(model)(model)["weights"][0].shape[0]
    except BenchError as error:
        return f"{name} is not a multilayer perceptron of a supported kind: {error.message}"
    except (AttributeError, IndexError, KeyError, TypeError, ValueError) as error:
        return f"{name} is not a multilayer perceptron of a supported kind: {error}."
    if hasattr(model.policy, "lstm_actor") or inputs != shape[0]:
        return f"{name} is recurrent or has a features extractor."
    return ""


def _actor_parts(model: BaseAlgorithm) -> Callable[[BaseAlgorithm], Parts]:
    """The function that reads the actor of a model."""
    policy: Any = model.policy
    if hasattr(policy, "actor_state"):
        return _flax
    if hasattr(policy, "mlp_extractor"):
        return _gaussian
    return _squashed_gaussian if hasattr(getattr(policy, "actor", None), "latent_pi") else _squashed


def _gaussian(model: BaseAlgorithm) -> Parts:
    policy: Any = model.policy
    layers = policy_layers(policy.mlp_extractor.policy_net, policy.action_net)
    return layers | _unscaled(policy.log_std.detach().numpy())


def _squashed_gaussian(model: BaseAlgorithm) -> Parts:
    actor: Any = model.policy.actor
    log_sigma = policy_layers(actor.log_std)
    return (
        policy_layers(actor.latent_pi, actor.mu)
        | _squashing(model)
        | {
            "log_sigma": log_sigma["biases"][0],
            "log_sigma_weight": log_sigma["weights"][0],
            "log_sigma_clip": LOG_SIGMA_CLIP,
        }
    )


def _squashed(model: BaseAlgorithm) -> Parts:
    policy: Any = model.policy
    *layers, squash = policy.actor.mu
    if type(squash).__name__ != "Tanh":
        raise TypeError("its last layer is not a tanh")
    return policy_layers(*layers) | _squashing(model)


def _flax(model: BaseAlgorithm) -> Parts:
    policy: Any = model.policy
    parameters = policy.actor_state.params["params"]
    name = type(policy.actor).__name__
    if name == "SquashedGaussianActor":
        *names, last = _dense(parameters)
        return (
            flax_layers(parameters, names, policy.actor.activation_fn)
            | _squashing(model)
            | {
                "log_sigma": np.asarray(parameters[last]["bias"]),
                "log_sigma_weight": np.asarray(parameters[last]["kernel"]),
                "log_sigma_clip": LOG_SIGMA_CLIP,
            }
        )
    layers = flax_layers(parameters, _dense(parameters), policy.actor.activation_fn)
    return layers | _unscaled(np.asarray(parameters["log_std"]))


def _dense(parameters: Parts) -> list[str]:
    """The names of the dense layers, first to last. Raises ``ValueError`` if there are others."""
    others = [name for name in parameters if not name.startswith("Dense_") and name != "log_std"]
    if others:
        raise ValueError(f"it has a layer {others[0]}")
    return sorted((name for name in parameters if name != "log_std"), key=lambda name: int(name[6:]))


def _unscaled(log_sigma: Array) -> Parts:
    """log σ (a,) of actions that are neither squashed nor scaled."""
    return {
        "log_sigma": log_sigma,
        "action_offset": np.zeros_like(log_sigma),
        "action_scale": np.ones_like(log_sigma),
    }


def _squashing(model: BaseAlgorithm) -> Parts:
    """The tanh and the box of the actions, as in SB3's ``unscale_action``."""
    box: Any = model.action_space
    low, high = box.low.ravel(), box.high.ravel()
    return {"squash": "tanh", "action_offset": (low + high) / 2, "action_scale": (high - low) / 2}
