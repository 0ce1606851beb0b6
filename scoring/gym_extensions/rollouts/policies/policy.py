"""A policy as plain arrays: a multilayer perceptron from an observation to an action."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from gym_extensions.errors import BenchError
from gym_extensions.rollouts.layout import MAX_UNPACKED_POLICY_BYTES
from gym_extensions.rollouts.policies.activations import Array
from gym_extensions.rollouts.policies.checks import array_errors, task_rows, text_of
from gym_extensions.rollouts.policies.forward import mean_and_log_sigma, to_action
from gym_extensions.rollouts.policies.keys import FORMAT, KEYS, LAYER, LAYER_FIELDS
from gym_extensions.rollouts.safe_npz import npz_bytes, read

HINT = "docs/rollout-log.md lists the arrays of a policy."


@dataclass(frozen=True, eq=False)
class Policy:
    """A policy with o observations and a actions. Arrays are float32 or float64, and are copied.

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
                layers = tuple(None if values is None else _copy(values) for values in value)
                object.__setattr__(self, field.name, layers)
            elif field.name in KEYS and KEYS[field.name].kind == "float" and value is not None:
                is_number = field.name == "observation_clip"
                object.__setattr__(self, field.name, float(value) if is_number else _copy(value))
        error = next(array_errors(self.arrays()), None)
        if self.masks and len(self.masks) != len(self.weights):
            error = (
                f"{len(self.masks)} masks for {len(self.weights)} layers; expected one per layer, or none."
            )
        if error is not None:
            raise BenchError("bad-policy", error, "policy()", HINT)

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, Array]) -> Policy:
        """The policy of a file's arrays, which :func:`array_errors` finds no error in."""
        layers = sum(name.startswith("weight_") for name in arrays)
        values: dict[str, Any] = {
            field: tuple(arrays.get(f"{part}_{layer}") for layer in range(layers))
            for field, part in LAYER_FIELDS.items()
        }
        for name, array in arrays.items():
            if not LAYER.fullmatch(name) and name != "format":
                values[name] = text_of(array) if KEYS[name].kind == "name" else array
        return cls(**values)

    @classmethod
    def from_bytes(cls, data: bytes) -> Policy:
        """The policy in the content of a file. Raises ``BenchError`` if the content is not a policy."""
        arrays = read(data, MAX_UNPACKED_POLICY_BYTES)
        if arrays is None:
            raise BenchError("bad-policy", "The file cannot be read.", hint=HINT)
        error = next(array_errors(arrays), None)
        if error is not None:
            raise BenchError("bad-policy", error, hint=HINT)
        return cls.from_arrays(arrays)

    def arrays(self) -> dict[str, Array]:
        """The arrays of the policy's file by name; what is None is left out, and names are ASCII bytes."""
        content: dict[str, Array] = {"format": np.array(FORMAT, np.int64)}
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name in LAYER_FIELDS:
                layers = {f"{LAYER_FIELDS[field.name]}_{layer}": array for layer, array in enumerate(value)}
                content |= {name: array for name, array in layers.items() if array is not None}
            elif isinstance(value, str):
                content[field.name] = np.frombuffer(value.encode(), np.uint8)
            elif value is not None:
                content[field.name] = np.asarray(value)
        return content

    def to_bytes(self) -> bytes:
        """The content of the policy's file. Equal policies give equal bytes."""
        return npz_bytes(self.arrays())

    @property
    def num_inputs(self) -> int | None:
        """The number of observations; None if the policy uses none."""
        sized = self.weights[0] if self.weights else self.observation_mean
        return None if sized is None else int(sized.shape[-2 if self.weights else -1])

    @property
    def num_tasks(self) -> int:
        """Rows of the arrays that have an axis of tasks; 0 if none has."""
        return task_rows(self.arrays())

    def act(self, observations: Array, rng: np.random.Generator | None = None, task: int = 0) -> Array:
        """Actions (n, a), not clipped to the action space.

        Args:
            observations: (n, …).
            rng: the source of noise; required unless the policy is deterministic.
            task: index of the task in the group, for policies with arrays per task.

        Raises:
            BenchError: a policy that samples has no ``rng``, or the observations have another size.
        """
        mean, log_sigma = mean_and_log_sigma(self, observations, task)
        if self.head == "deterministic":
            return to_action(self, mean)
        if rng is None:
            raise BenchError("no-generator", "The policy samples.", "act()", "Pass rng, a numpy Generator.")
        if self.head == "uniform":
            return to_action(self, rng.uniform(-1.0, 1.0, mean.shape).astype(mean.dtype))
        noise = rng.standard_normal(mean.shape, mean.dtype.type)
        return to_action(self, mean + np.exp(log_sigma) * noise)

    def interval(self, observations: Array, task: int = 0, sigmas: float = 8.0) -> tuple[Array, Array]:
        """Lower and upper bounds (n, a) of the actions: ± ``sigmas`` · σ around a Gaussian's mean."""
        mean, log_sigma = mean_and_log_sigma(self, observations, task)
        if self.head == "deterministic":
            return (action := to_action(self, mean)), action
        width = 1.0 if self.head == "uniform" else sigmas * np.exp(log_sigma)
        return to_action(self, mean - width), to_action(self, mean + width)


def _copy(values: Array) -> Array:
    return np.array(values, order="C")
