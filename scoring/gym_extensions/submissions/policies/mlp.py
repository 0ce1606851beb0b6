"""A policy as plain arrays: a multilayer perceptron from an observation."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gym_extensions.errors import BenchError
from gym_extensions.submissions.policies import mlp_arrays
from gym_extensions.submissions.policies.mlp_arrays import ACTIVATIONS, KEYS, LAYER_FIELDS, Array, Arrays

if TYPE_CHECKING:
    import torch

HINT = "docs/rollout-log.md lists the arrays of a policy."
BUFFERS = (
    *("observation_mean", "observation_scale", "action_offset", "action_scale"),
    *("log_sigma", "log_sigma_weight", "log_sigma_clip"),
)
"""The arrays of a policy that a PyTorch module does not train."""


@dataclass(frozen=True, eq=False, repr=False)
class Policy:
    """A policy with o observations and a actions. Arrays are float32 or float64, and are copied.

    It computes in float64, with the same bits on every processor (docs/rollout-log.md#arithmetic).

    An observation x, converted to ``observation_dtype`` and flattened, gives the action

    1. x ← clip((x − ``observation_mean``) / ``observation_scale``, ± ``observation_clip``)
    2. h ← ``activation``(h · weight + bias) for every layer but the last, which has no activation
    3. mean ← ``output_activation``(h · weight + bias); 0 without layers
    4. y ← mean (``deterministic``), mean + σ · noise (``gaussian``), or uniform on [−1, 1] (``uniform``)
    5. action = ``action_offset`` + ``action_scale`` · ``squash``(y)

    with log σ = ``log_sigma``, or clip(h · ``log_sigma_weight`` + ``log_sigma``, ``log_sigma_clip``), where h
    is the input of the last layer.

    The arrays of steps 1 to 3, ``log_sigma`` and ``log_sigma_weight`` may have a leading axis of tasks: row k
    belongs to the task at index k of the group, and the last row also to all later tasks.

    Args:
        action_offset: (a,).
        action_scale: (a,), positive.
        weights: (inputs, outputs) of each layer, first to last; none for a constant policy.
        biases: (outputs,) of each layer.
        masks: bool (inputs, outputs) of each layer, which multiply the weights; empty, or None where a layer
            has none.
        activation: of the hidden layers: linear, tanh, relu, leaky_relu (slope .01), elu or silu.
        output_activation: of the mean: one of the same.
        squash: of the action: linear or tanh.
        head: deterministic, gaussian or uniform.
        log_sigma: (a,); required by ``gaussian``. A deterministic policy may state it and does not use it.
        log_sigma_weight: (inputs of the last layer, a), if σ depends on the observation.
        log_sigma_clip: (2,), lower and upper bound of log σ.
        observation_dtype: float32 or float64.
        observation_mean: (o,); None if observations are not normalized.
        observation_scale: (o,), positive; what observations are divided by, any ε included.
        observation_clip: bound of normalized observations; None if they are not clipped.

    Raises:
        BenchError: an array is missing, of a wrong shape or type, or not finite, or a name is unknown.

    Example:
        >>> policy = Policy(
        ...     action_offset=np.zeros(1),
        ...     action_scale=np.ones(1),
        ...     weights=(np.array([[0.5], [2.0]]),),
        ...     biases=(np.array([0.25]),),
        ... )
        >>> policy.act(np.array([[1.0, 1.0]]))
        array([[2.75]])
    """

    action_offset: Array
    action_scale: Array
    weights: tuple[Array, ...] = ()
    biases: tuple[Array, ...] = ()
    masks: tuple[Array | None, ...] = ()
    activation: str = "linear"
    output_activation: str = "linear"
    squash: str = "linear"
    head: str = "deterministic"
    log_sigma: Array | None = None
    log_sigma_weight: Array | None = None
    log_sigma_clip: Array | None = None
    observation_dtype: str = "float32"
    observation_mean: Array | None = None
    observation_scale: Array | None = None
    observation_clip: float | None = None

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name in LAYER_FIELDS:
                value = tuple(None if values is None else _copied(values) for values in value)
            elif field.name == "observation_clip":
                value = None if value is None else float(value)
            elif KEYS[field.name].kind == "float" and value is not None:
                value = _copied(value)
            object.__setattr__(self, field.name, value)
        error = next(mlp_arrays.array_errors(self.arrays()), None)
        if self.masks and len(self.masks) != len(self.weights):
            error = f"{len(self.masks)} masks for {len(self.weights)} layers; expected one each, or none."
        if error is not None:
            raise BenchError("bad-policy", error, "policy()", HINT)

    @classmethod
    def from_arrays(cls, arrays: Arrays) -> Policy:
        """The policy of a file's arrays, which :func:`array_errors` finds no error in."""
        layers = sum(name.startswith("weight_") for name in arrays)
        values: dict[str, Any] = {
            field: tuple(arrays.get(f"{part}_{layer}") for layer in range(layers))
            for field, part in LAYER_FIELDS.items()
        }
        for name, array in arrays.items():
            if not mlp_arrays.LAYER.fullmatch(name) and name != "format":
                values[name] = mlp_arrays.text_of(array) if KEYS[name].kind == "name" else array
        return cls(**values)

    def arrays(self) -> dict[str, Array]:
        """The arrays of the policy's file by name; what is None is left out, and names are ASCII bytes."""
        content: dict[str, Array] = {"format": np.array(mlp_arrays.FORMAT, np.int64)}
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name in LAYER_FIELDS:
                part = LAYER_FIELDS[field.name]
                content |= {f"{part}_{i}": array for i, array in enumerate(value) if array is not None}
            elif isinstance(value, str):
                content[field.name] = np.frombuffer(value.encode(), np.uint8)
            elif value is not None:
                content[field.name] = np.asarray(value)
        return content

    @property
    def num_inputs(self) -> int | None:
        """The number of observations; None if the policy uses none."""
        if self.weights:
            return self.weights[0].shape[-2]
        return None if self.observation_mean is None else self.observation_mean.shape[-1]

    @property
    def num_actions(self) -> int:
        """The number of values of an action."""
        return len(self.action_offset)

    @property
    def num_tasks(self) -> int:
        """Rows of the arrays that have an axis of tasks; 0 if none has."""
        for name, values in self.arrays().items():
            key = mlp_arrays.key_of(name)
            if key is not None and key.has_tasks and values.ndim > len(key.shape):
                return len(values)
        return 0

    def act(self, observations: Array, rng: np.random.Generator | None = None, task: int = 0) -> Array:
        """Actions, not clipped to the action space: (a,) for one observation (o,), (n, a) for many (n, …).

        They are float64. An environment clips them to its action space and rounds them to float32.

        Args:
            observations: one or many.
            rng: the source of noise; required unless the policy is deterministic.
            task: index of the task in the group, for policies with arrays per task.

        Raises:
            BenchError: a policy that samples has no ``rng``, or the observations have another size.
        """
        if np.ndim(observations) == 1:
            return self.act(np.asarray(observations)[None], rng, task)[0]
        mean, log_sigma = mean_and_log_sigma(self, observations, task)
        if self.head == "deterministic":
            return to_action(self, mean)
        if rng is None:
            raise BenchError("no-generator", "The policy samples.", "act()", "Pass rng, a numpy Generator.")
        if self.head == "uniform":
            return to_action(self, rng.uniform(-1.0, 1.0, mean.shape))
        noise = rng.standard_normal(mean.shape, log_sigma.dtype.type)
        return to_action(self, mean + np.exp(log_sigma) * noise)

    def reset(self) -> None:
        """Starts new episodes, as for networks with a state; plain arrays have none."""

    @property
    def masked_weights(self) -> tuple[Array, ...]:
        """The weights of all layers, masked ones as 0."""
        masks = self.masks or (None,) * len(self.weights)
        pairs = zip(self.weights, masks, strict=True)
        return tuple(weight if mask is None else weight * mask for weight, mask in pairs)

    def flat_weights(self) -> Array:
        """The :attr:`masked_weights` in one row."""
        return np.concatenate([np.zeros(0), *(layer.ravel() for layer in self.masked_weights)])

    def to_torch(self, task: int = 0) -> torch.nn.Module:
        """A PyTorch module of the arrays of a task, with parameters that can be trained further.

        ``module(observation)`` gives the action without noise, and ``module(observation, noise)`` that of a
        gaussian policy with standard normal numbers (…, a).

        Raises:
            BenchError: the policy has no layers or is uniform, or torch is not installed.
        """
        return _torch_module(self, task)

    def to_onnx(self, path: str | Path | None = None, task: int = 0) -> bytes:
        """The policy as an ONNX network, which ``OnnxPolicy`` describes; needs torch and the extra ``onnx``.

        The network is also written to ``path``, if any. It has the arrays of one task, in float64, in which
        the policy computes and draws its noise.

        Raises:
            BenchError: the policy has no layers or is uniform, or torch or onnx is not installed.
        """
        from gym_extensions.submissions.policies.conversion import from_torch

        module, inputs = self.to_torch(task).double(), self.weights[0].shape[-2:-1]
        noise = self.num_actions if self.head == "gaussian" else 0
        return from_torch(module, inputs, noise=noise, dtype=self.observation_dtype).to_onnx(path)


def by_task(policies: Sequence[Policy], shared: int = 0) -> Policy:
    """One policy with a row per task. The first ``shared`` layers are equal, and have no axis of tasks."""
    values: dict[str, Any] = {}
    for name in (field.name for field in fields(Policy)):
        rows = [getattr(policy, name) for policy in policies]
        if name in LAYER_FIELDS:
            same = 0 if name == "masks" else shared
            layers = zip(*(row[same:] for row in rows), strict=True)
            stacked = [None if layer[0] is None else np.stack(layer) for layer in layers]
            values[name] = (*rows[0][:same], *stacked)
        else:
            values[name] = np.stack(rows) if KEYS[name].has_tasks and rows[0] is not None else rows[0]
    return Policy(**values)


def _copied(values: Any) -> Array:
    """A copy of an array; of a PyTorch tensor also if it is trained, on another device or in bfloat16."""
    if hasattr(values, "detach"):
        values = values.detach().cpu()
        is_short = values.is_floating_point() and values.element_size() < 4
        values = (values.float() if is_short else values).numpy()
    return np.array(values, order="C")


def mean_and_log_sigma(policy: Policy, observations: Array, task: int = 0) -> tuple[Array, Array]:
    """The mean before ``squash`` (n, a) and log σ, (a,) or (n, a), for observations (n, …).

    log σ is 0 if it is not stated. Raises ``BenchError`` if the observations have another size.
    """
    # It loads a compiler, which scoring does not need.
    from gym_extensions.submissions.policies import arithmetic

    seen = _flattened(policy, observations)
    output, hidden = arithmetic.forward(seen, *_constants(policy, seen.shape[1], task))
    mean = output if policy.weights else np.zeros((len(seen), policy.num_actions))
    if policy.log_sigma is None:
        return mean, np.zeros(policy.num_actions)
    log_sigma = _row(policy.log_sigma, 1, task)
    if policy.log_sigma_weight is not None:
        log_sigma = hidden @ _row(policy.log_sigma_weight, 2, task) + log_sigma
    return mean, log_sigma if policy.log_sigma_clip is None else np.clip(log_sigma, *policy.log_sigma_clip)


def hidden_outputs(policy: Policy, observations: Array, task: int = 0) -> list[Array]:
    """The outputs (n, units) of every hidden layer for observations (n, …), as the policy computes them.

    Raises ``BenchError`` if the observations have another size.
    """
    from gym_extensions.submissions.policies import arithmetic

    seen = _flattened(policy, observations)
    normalization, bound, sizes, parameters, kind, _ = _constants(policy, seen.shape[1], task)
    # The first layers are a network, whose output has the activation of a hidden layer.
    parts = (sizes[:end] for end in range(2, len(sizes)))
    return [arithmetic.forward(seen, normalization, bound, part, parameters, kind, kind)[0] for part in parts]


def _flattened(policy: Policy, observations: Array) -> Array:
    """Observations (n, …) as the policy reads them, (n, o)."""
    seen = np.asarray(observations, policy.observation_dtype)
    seen = seen.reshape(len(seen), -1).astype(np.float64)
    mlp_arrays.require_size(seen, policy.num_inputs)
    return seen


def to_action(policy: Policy, values: Array) -> Array:
    """Actions (n, a) from the values of the head, not clipped to the action space."""
    from gym_extensions.submissions.policies import arithmetic

    values = np.array(values, np.float64, order="C")
    arithmetic.activate(values.reshape(-1), ACTIVATIONS.index(policy.squash))
    return policy.action_offset + policy.action_scale * values


@functools.lru_cache(maxsize=16)
def _constants(policy: Policy, inputs: int, task: int) -> tuple[Any, ...]:
    """What :func:`arithmetic.forward` needs besides the observations, which have ``inputs`` values."""
    normalization = np.stack([np.zeros(inputs), np.ones(inputs)])
    if policy.observation_mean is not None and policy.observation_scale is not None:
        normalization[:] = _row(policy.observation_mean, 1, task), _row(policy.observation_scale, 1, task)
    masks = policy.masks or (None,) * len(policy.weights)
    sizes, parts = [inputs], [np.empty(0)]
    for weights, mask, biases in zip(policy.weights, masks, policy.biases, strict=True):
        weight, bias = _row(weights, 2, task), _row(biases, 1, task)
        parts += [(weight if mask is None else np.where(_row(mask, 2, task), weight, 0.0)).ravel(), bias]
        sizes.append(len(bias))
    bound = np.inf if policy.observation_clip is None else policy.observation_clip
    kinds = (ACTIVATIONS.index(name) for name in (policy.activation, policy.output_activation))
    return normalization, bound, np.array(sizes), np.concatenate(parts, dtype=np.float64), *kinds


def _row(values: Array, ndim: int, task: int) -> Array:
    """The array of a task, a row of the leading axis if there is that axis."""
    return values if values.ndim == ndim else values[min(task, len(values) - 1)]


def _torch_module(policy: Policy, task: int) -> torch.nn.Module:
    try:
        import torch
    except ImportError as error:
        hint = "Run: pip install torch"
        raise BenchError("missing-extra", "The conversion needs torch.", hint=hint) from error
    if policy.head == "uniform" or not policy.weights:
        message = "The policy is uniform." if policy.head == "uniform" else "The policy has no layers."
        raise BenchError("unsupported-policy", message, "policy", "Only a policy with layers is converted.")
    functional = torch.nn.functional
    activations: dict[str, Any] = {
        "linear": lambda values: values,
        "tanh": torch.tanh,
        "relu": functional.relu,
        "leaky_relu": lambda values: functional.leaky_relu(values, mlp_arrays.LEAK),
        # onnxruntime has no Elu of float64
        "elu": lambda values: torch.where(values > 0, values, values.clamp(max=0).exp() - 1),
        "silu": functional.silu,
    }

    class PolicyModule(torch.nn.Module):
        """Actions (…, a) from observations (…, o); the mean without noise (…, a)."""

        def __init__(self) -> None:
            super().__init__()
            self.layers = torch.nn.ModuleList()
            for weights, biases in zip(policy.masked_weights, policy.biases, strict=True):
                weight, bias = _row(weights, 2, task), torch.tensor(_row(biases, 1, task))
                layer = torch.nn.Linear(*weight.shape).to(torch.from_numpy(weight).dtype)
                layer.load_state_dict({"weight": torch.tensor(weight.T), "bias": bias})
                self.layers.append(layer)
            for name in BUFFERS:
                if (values := getattr(policy, name)) is not None:
                    self.register_buffer(name, torch.tensor(_row(values, len(KEYS[name].shape), task)))

        def forward(self, observation: torch.Tensor, noise: torch.Tensor | None = None) -> torch.Tensor:
            own: Any = self
            values = observation.to(getattr(torch, policy.observation_dtype))
            if policy.observation_mean is not None:
                values = (values - own.observation_mean) / own.observation_scale
            if (bound := policy.observation_clip) is not None:
                values = values.clamp(-bound, bound)
            values = values.to(own.layers[0].weight.dtype)
            for layer in own.layers[:-1]:
                values = activations[policy.activation](layer(values))
            mean = activations[policy.output_activation](own.layers[-1](values))
            if noise is not None and policy.head == "gaussian":
                log_sigma = own.log_sigma
                if policy.log_sigma_weight is not None:
                    log_sigma = values @ own.log_sigma_weight + log_sigma
                if policy.log_sigma_clip is not None:
                    log_sigma = log_sigma.clamp(*own.log_sigma_clip)
                mean = mean + log_sigma.exp() * noise
            return own.action_offset + own.action_scale * activations[policy.squash](mean)

    return PolicyModule()
