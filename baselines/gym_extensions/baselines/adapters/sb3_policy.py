"""The policy of a Stable-Baselines3 or SBX model as plain arrays, or as an ONNX network.

Plain arrays are multilayer perceptrons of flat observations: the Gaussian actors of PPO, A2C and TRPO, the
squashed Gaussian actors of SAC and TQC, the deterministic actors of TD3 and DDPG, and the actors of SBX's PPO
and SAC. Other policies of PyTorch become networks: images, own classes, own features extractors, LSTMs.
"""

from typing import Any

import numpy as np
import torch
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.torch_layers import FlattenExtractor
from stable_baselines3.common.vec_env import VecNormalize

from gym_extensions.baselines.agent import Array
from gym_extensions.errors import BenchError
from gym_extensions.submissions.policies import conversion, files, mlp, onnx

ACTIVATIONS: dict[type[torch.nn.Module], str] = {
    torch.nn.Tanh: "tanh",
    torch.nn.ReLU: "relu",
    torch.nn.LeakyReLU: "leaky_relu",
    torch.nn.ELU: "elu",
    torch.nn.SiLU: "silu",
}
"""The name in a policy of each activation, with PyTorch's default settings."""
LIBRARIES = ("stable_baselines3", "sb3_contrib", "sbx", "torch", "builtins", "abc", "typing")
ACTING = (
    *("predict", "_predict", "forward", "forward_actor", "extract_features"),
    *("get_distribution", "get_action_dist_params", "_get_action_dist_from_latent"),
)
Parts = dict[str, Any]
"""Arguments of :class:`gym_extensions.policies.Policy`."""


def policy_layers(*modules: torch.nn.Module) -> Parts:
    """The layers of networks that are applied one after the other, as arguments of a policy.

    Args:
        modules: for example the hidden layers and the layer of the mean. Every linear layer but the last is
            followed by the same activation.

    Returns:
        Weights (inputs, outputs), the transpose of PyTorch's, biases, and the name of the activation.

    Raises:
        BenchError: a module of another kind, another order of layers, or two different activations.

    Example:
        >>> from torch import nn
        >>> layers = policy_layers(nn.Sequential(nn.Linear(3, 8), nn.Tanh()), nn.Linear(8, 2))
        >>> [weights.shape for weights in layers["weights"]], layers["activation"]
        ([(3, 8), (8, 2)], 'tanh')
    """
    # ``modules`` visits a layer once, and a sequence may use it several times.
    parts = [part for each in modules for part in (each if isinstance(each, torch.nn.Sequential) else [each])]
    leaves = [leaf for part in parts for leaf in part.modules() if not any(leaf.children())]
    linear: Any = leaves[::2]
    activations = set[str]()
    for leaf in leaves:
        kind = type(leaf)
        if isinstance(leaf, torch.nn.Linear):
            continue
        arguments = ("alpha", "negative_slope")
        if kind not in ACTIVATIONS or any(
            getattr(leaf, name, None) != getattr(kind(), name, None) for name in arguments
        ):
            message = f"{kind.__name__} cannot be part of a policy."
            supported = ", ".join(["Linear", *(each.__name__ for each in ACTIVATIONS)])
            raise BenchError("bad-policy", message, "policy_layers()", f"A policy supports {supported}.")
        activations.add(ACTIVATIONS[kind])
    is_linear = [isinstance(leaf, torch.nn.Linear) for leaf in leaves]
    if is_linear != [True, False] * (len(linear) - 1) + [True] or len(activations) > 1:
        names = ", ".join(type(leaf).__name__ for leaf in leaves)
        hint = "Give linear layers with the same activation after each but the last."
        raise BenchError("bad-policy", f"The modules are {names}.", "policy_layers()", hint)
    return {
        "weights": tuple(_array(layer.weight).T for layer in linear),
        "biases": tuple(
            np.zeros(layer.out_features, np.float32) if layer.bias is None else _array(layer.bias)
            for layer in linear
        ),
        "activation": activations.pop() if activations else "linear",
    }


def _array(values: torch.Tensor) -> Array:
    return values.detach().cpu().numpy()


LOG_SIGMA_CLIP = np.array([-20.0, 2.0], np.float32)
"""Bounds of log σ of a squashed Gaussian actor, in SB3 and SBX."""
NOT_PLAIN = (BenchError, AttributeError, IndexError, KeyError, TypeError, ValueError)
"""What reading a policy raises if it has other modules than a multilayer perceptron."""


def exported(
    model: BaseAlgorithm,
    deterministic: bool = True,
    normalizer: VecNormalize | None = None,
    observation_shape: tuple[int, ...] | None = None,
) -> files.AnyPolicy:
    """The policy of a model, trained by this package or loaded with ``PPO.load``.

    Args:
        model: of Stable-Baselines3, SB3-Contrib or SBX.
        deterministic: whether the policy takes the mean action or samples.
        normalizer: what normalized the observations in training; that of the model's environment if None.
        observation_shape: of the environment, if the model has images with the channels first and the
            environment has them last; that of the model if None.

    Raises:
        BenchError: the policy uses ``use_sde`` or cannot be exported, or it is a network and the extra
            ``onnx`` is not installed.
    """
    policy: Any = model.policy
    statistics = _statistics(normalizer or model.get_vec_normalize_env())

    def unsupported(reason: str) -> BenchError:
        message = f"The policy of {type(model).__name__}, {type(policy).__name__}, {reason}."
        hint = "Use a policy of PyTorch without use_sde, or train without storing the policy."
        return BenchError("unsupported-policy", message, "policy()", hint)

    if getattr(model, "use_sde", False):
        raise unsupported("uses state-dependent exploration (use_sde)")
    own = _overridden(policy)
    if "predict" in own or (own and (not deterministic or hasattr(policy, "lstm_actor"))):
        raise unsupported(f"overrides {', '.join(own)}, which a network cannot follow")
    try:
        parts = plain_parts(model)
    except NOT_PLAIN as error:
        if hasattr(policy, "actor_state"):
            raise unsupported(f"is not one of PyTorch, nor a multilayer perceptron: {error}") from error
        if not (model.observation_space.shape and model.action_space.shape):
            raise unsupported("does not have boxes of numbers as spaces") from error
        return _network(model, deterministic, statistics, observation_shape)
    parts["head"] = "deterministic" if deterministic or "log_sigma" not in parts else "gaussian"
    return mlp.Policy(**parts, **statistics)


def _statistics(normalizer: VecNormalize | None) -> Parts:
    """What standardizes the observations; empty if they are not normalized."""
    if normalizer is None or not normalizer.norm_obs:
        return {}
    moments: Any = normalizer.obs_rms
    return {
        "observation_mean": moments.mean,
        "observation_scale": np.sqrt(moments.var + normalizer.epsilon),
        "observation_clip": float(normalizer.clip_obs),
    }


def plain_parts(model: BaseAlgorithm) -> Parts:
    """The network and the head. Raises ``NOT_PLAIN`` if the policy is not a multilayer perceptron."""
    policy: Any = model.policy
    parts = _flax(model) if hasattr(policy, "actor_state") else _torch(model)
    if own := _overridden(policy):
        raise ValueError(f"its class overrides {', '.join(own)}")
    is_flat = parts["weights"][0].shape[:1] == model.observation_space.shape
    # Observations may go through other layers than a flattening before the actor.
    owners = [policy] if hasattr(policy, "actor_state") else [policy, getattr(policy, "actor", None)]
    names = ("features_extractor", "pi_features_extractor")
    extractors = [getattr(owner, name, None) for owner in owners for name in names]
    has_extractor = any(each is not None and type(each) is not FlattenExtractor for each in extractors)
    if not is_flat or has_extractor or hasattr(policy, "lstm_actor"):
        raise ValueError("it has a features extractor or an LSTM, or its observations are not flat")
    return parts


def _overridden(policy: Any) -> list[str]:
    """The methods that choose actions which classes of the user override, so that layers do not tell all."""
    parts = [policy, getattr(policy, "actor", None), getattr(policy, "mlp_extractor", None)]
    kinds = {kind for part in parts for kind in type(part).__mro__}
    own = [kind for kind in kinds if kind.__module__.partition(".")[0] not in LIBRARIES]
    return sorted({name for kind in own for name in ACTING if name in vars(kind)})


class _Acting(torch.nn.Module):
    """The actions of a model, not clipped: the best ones, or samples with noise, and an LSTM's next state.

    The state of an episode has the hidden state and the cell state of each layer: (layers, 2, hidden).
    """

    def __init__(self, model: BaseAlgorithm, statistics: Parts, swap: bool, samples: bool) -> None:
        super().__init__()
        self.policy: Any = model.policy
        self.swap, self.samples, box = swap, samples, model.action_space
        self.lstm: torch.nn.LSTM | None = getattr(self.policy, "lstm_actor", None)
        self.squashes = bool(self.policy.squash_output)
        self.limits = [torch.as_tensor(each) for each in (box.low, box.high)]  # type: ignore[attr-defined]
        self.statistics: tuple[Any, ...] = ()
        if statistics:
            mean, scale, bound = statistics.values()
            self.statistics = (torch.as_tensor(mean), torch.as_tensor(scale), bound)

    def forward(
        self, observation: torch.Tensor, *inputs: torch.Tensor
    ) -> torch.Tensor | tuple[torch.Tensor, torch.Tensor]:
        """Actions from observations, then the noise if the model samples, then the state of an LSTM."""
        noise = inputs[0] if self.samples else None
        if self.statistics:
            mean, scale, bound = self.statistics
            observation = ((observation - mean) / scale).clamp(-bound, bound)
        if self.swap:
            observation = observation.permute(0, 3, 1, 2)
        next_state = None
        if self.lstm is not None:
            features = self.policy.extract_features(observation, self.policy.pi_features_extractor)
            hidden, cell = inputs[-1].permute(2, 1, 0, 3).contiguous()
            latent, states = self.lstm(features[None], (hidden, cell))
            next_state = torch.stack(states).permute(2, 1, 0, 3)
            actor = self.policy.mlp_extractor.forward_actor(latent[0])
            actions = self._sample(self.policy._get_action_dist_from_latent(actor).distribution, noise)
        elif noise is None:
            actions = self.policy._predict(observation, deterministic=True)
        elif hasattr(self.policy, "get_distribution"):
            actions = self._sample(self.policy.get_distribution(observation).distribution, noise)
        else:
            mean, log_sigma, _ = self.policy.actor.get_action_dist_params(observation)
            actions = torch.tanh(mean + log_sigma.exp() * noise)
        if self.squashes:
            low, high = self.limits
            actions = low + 0.5 * (actions + 1) * (high - low)
        result: torch.Tensor = actions.flatten(1)
        return result if next_state is None else (result, next_state)

    @staticmethod
    def _sample(normal: Any, noise: torch.Tensor | None) -> Any:
        return normal.mean if noise is None else normal.mean + normal.stddev * noise


def _network(
    model: BaseAlgorithm, deterministic: bool, statistics: Parts, shape: tuple[int, ...] | None
) -> onnx.OnnxPolicy:
    space: Any = model.observation_space
    shape, actor = shape or space.shape, getattr(model.policy, "actor", None)
    can_sample = hasattr(model.policy, "get_distribution") or hasattr(actor, "get_action_dist_params")
    samples = can_sample and not deterministic
    acting = _Acting(model, statistics, swap=shape != space.shape, samples=samples).eval()
    lstm = acting.lstm
    return conversion.from_torch(
        acting,
        shape,
        state_shape=None if lstm is None else (lstm.num_layers, 2, lstm.hidden_size),
        noise=int(np.prod(model.action_space.shape or ())) if samples else 0,
        dtype=space.dtype.name if space.dtype.name in ("float32", "float64", "uint8") else "float32",
    )


def _torch(model: BaseAlgorithm) -> Parts:
    policy: Any = model.policy
    if hasattr(policy, "mlp_extractor"):  # PPO, A2C, TRPO
        layers = policy_layers(policy.mlp_extractor.policy_net, policy.action_net)
        return layers | _unscaled(_array(policy.log_std))
    if hasattr(policy.actor, "latent_pi"):  # SAC, TQC
        sigma = policy_layers(policy.actor.log_std)
        layers = policy_layers(policy.actor.latent_pi, policy.actor.mu)
        return layers | _squashing(model) | _sigma(sigma["weights"][0], sigma["biases"][0])
    *hidden, squash = policy.actor.mu  # TD3, DDPG
    if type(squash).__name__ != "Tanh":
        raise TypeError("its last layer is not a tanh")
    return policy_layers(*hidden) | _squashing(model)


def _flax(model: BaseAlgorithm) -> Parts:
    policy: Any = model.policy
    parameters = policy.actor_state.params["params"]
    activation = getattr(policy.actor.activation_fn, "__name__", "")
    names = sorted((name for name in parameters if name != "log_std"), key=lambda name: int(name[6:]))
    if activation not in ACTIVATIONS.values() or not all(name.startswith("Dense_") for name in names):
        raise ValueError(f"it has the layers {', '.join(parameters)} and the activation {activation!r}")
    weights, biases = ([np.asarray(parameters[name][key]) for name in names] for key in ("kernel", "bias"))
    head: Parts = {}
    if type(policy.actor).__name__ == "SquashedGaussianActor":
        head = _squashing(model) | _sigma(weights.pop(), biases.pop())
    else:
        head = _unscaled(np.asarray(parameters["log_std"]))
    return {"weights": tuple(weights), "biases": tuple(biases), "activation": activation} | head


def _sigma(weight: Array, bias: Array) -> Parts:
    """The layer of log σ of a squashed Gaussian."""
    return {"log_sigma": bias, "log_sigma_weight": weight, "log_sigma_clip": LOG_SIGMA_CLIP}


def _unscaled(log_sigma: Array) -> Parts:
    """log σ (a,) of actions that are neither squashed nor scaled."""
    box = {"action_offset": np.zeros_like(log_sigma), "action_scale": np.ones_like(log_sigma)}
    return {"log_sigma": log_sigma} | box


def _squashing(model: BaseAlgorithm) -> Parts:
    """The tanh and the box of the actions, as in SB3's ``unscale_action``."""
    box: Any = model.action_space
    low, high = box.low.ravel(), box.high.ravel()
    return {"squash": "tanh", "action_offset": (low + high) / 2, "action_scale": (high - low) / 2}
