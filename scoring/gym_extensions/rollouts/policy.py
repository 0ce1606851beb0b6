"""A policy as plain arrays: a multilayer perceptron from an observation. The policies of a run."""

from __future__ import annotations

import hashlib
import io
import zipfile
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.catalog.protocol import stages
from gym_extensions.errors import BenchError
from gym_extensions.files import write_bytes
from gym_extensions.rollouts.layout import MAX_FILE_BYTES, MAX_POLICY_BYTES, POLICIES, read_regular, run_file
from gym_extensions.rollouts.policy_arrays import (
    ACTIVATIONS,
    FORMAT,
    KEYS,
    LAYER,
    LAYER_FIELDS,
    Array,
    Arrays,
    array_errors,
    task_rows,
    text_of,
)

HINT = "docs/rollout-log.md lists the arrays of a policy."
NPZ_ERRORS = (
    *(OSError, ValueError, KeyError, EOFError, MemoryError, NotImplementedError, RuntimeError, SyntaxError),
    *(zipfile.BadZipFile, zlib.error),
)
"""What numpy and zipfile raise for a file that is not an .npz file."""
Key = tuple[int, str | None]
"""Stage and, in the single protocol, name of the trained task."""


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
    def from_arrays(cls, arrays: Arrays) -> Policy:
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


def _copy(values: Array) -> Array:
    return np.array(values, order="C")


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


def prefix(key: Key) -> str:
    """What the names of a policy's arrays begin with: ``stage3/``, or ``stage1/TASK/`` (single)."""
    stage, task = key
    return f"stage{stage}/" if task is None else f"stage{stage}/{task}/"


def policy_keys(protocol: str, group: TaskGroup) -> list[Key]:
    """Stage and task name (None but in the single protocol) of every policy of a run."""
    tasks: list[str | None] = [task.name for task in group.tasks] if protocol == "single" else [None]
    return [(stage, task) for stage in stages(protocol, len(group.tasks)) for task in tasks]


def content_sha256(arrays: Arrays) -> str:
    """The SHA-256 of arrays by their full names, which does not depend on how they are packed.

    For every array, sorted by name: a line with its name, type and shape; its values in C order,
    little-endian.
    """
    digest = hashlib.sha256()
    for name in sorted(arrays):
        values = np.ascontiguousarray(arrays[name], arrays[name].dtype.newbyteorder("<"))
        shape = ",".join(map(str, arrays[name].shape))
        digest.update(f"{name} {values.dtype.str} {shape}\n".encode())
        digest.update(values.tobytes())
    return digest.hexdigest()


def npz_bytes(arrays: Arrays) -> bytes:
    """The content of an .npz file. Equal arrays give equal bytes (numpy dates every member 1980-01-01)."""
    content = io.BytesIO()
    np.savez_compressed(content, allow_pickle=False, **arrays)
    return content.getvalue()


def npz_arrays(data: bytes) -> dict[str, Array]:
    """The arrays of an .npz file by name, never a pickle.

    Raises:
        BenchError: it is not such a file, or unpacks to more than ``MAX_POLICY_BYTES``.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            size = sum(info.file_size for info in archive.infolist())
        if size > MAX_POLICY_BYTES:
            raise ValueError(f"it unpacks to {size} bytes; the limit is {MAX_POLICY_BYTES}")
        with np.load(io.BytesIO(data), allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
    except NPZ_ERRORS as error:
        raise BenchError("bad-policy", f"The file cannot be read: {error}.", hint=HINT) from error
    if not all(isinstance(values, np.ndarray) for values in arrays.values()):
        raise BenchError("bad-policy", "The file has a member that is no array.", hint=HINT)
    return arrays


def run_arrays(policies: Mapping[Key, Policy]) -> dict[str, Array]:
    """The arrays of a run's policies by their full names."""
    return {
        f"{prefix(key)}{name}": values
        for key, policy in policies.items()
        for name, values in policy.arrays().items()
    }


def write_policies(path: Path, policies: Mapping[Key, Policy]) -> None:
    """Writes the policies of a run into one .npz file, whole or not at all.

    Args:
        path: ``run3.npz``.
        policies: by stage and, in the single protocol, task name (else None).
    """
    write_bytes(path, npz_bytes(run_arrays(policies)))


def old_policy_files(folder: Path, group: TaskGroup, protocol: str, run: int) -> dict[Key, Path]:
    """TRANSITIONAL: the policies of a run in the folder ``policies`` of its group, a file each, by key.

    Entries that were migrated from the form before 2026-12 have them until their policies are repacked
    (``scoring/migrate_format_1.py --repack-policies``). Remove this function then.
    """
    names = {
        key: f"{protocol}-run{run}-stage{key[0]}{'' if key[1] is None else f'-{key[1]}'}.npz"
        for key in policy_keys(protocol, group)
    }
    paths = {key: folder / group.name / "policies" / name for key, name in names.items()}
    return {key: path for key, path in paths.items() if path.is_file()}


def has_policies(folder: Path, group: TaskGroup, protocol: str, run: int) -> bool:
    """Whether the policies of a run lie in the submission."""
    path = folder / run_file(group.name, protocol, run, POLICIES)
    return path.is_file() or bool(old_policy_files(folder, group, protocol, run))


def read_arrays(folder: Path, group: TaskGroup, protocol: str, run: int) -> dict[str, Array]:
    """The arrays of a run's policies by their full names, as they are; for a limited process.

    Args:
        folder: the submission.
        group: the group.
        protocol: one of ``PROTOCOLS``.
        run: the run.

    Raises:
        BenchError: there are none, or a file is not an .npz file within the limits.
    """
    path = folder / run_file(group.name, protocol, run, POLICIES)
    if path.is_file() or not (old := old_policy_files(folder, group, protocol, run)):
        return _arrays_of_file(path)
    return {
        f"{prefix(key)}{name}": values
        for key, file in old.items()
        for name, values in _arrays_of_file(file).items()
    }


def _arrays_of_file(path: Path) -> dict[str, Array]:
    try:
        return npz_arrays(read_regular(path, MAX_FILE_BYTES[POLICIES]))
    except OSError as error:
        message = f"The policies cannot be read: {error.strerror or error}."
        raise BenchError("bad-policy", message, str(path), HINT) from error
    except BenchError as error:
        raise BenchError(error.code, error.message, str(path), error.hint) from error


def run_errors(arrays: Arrays, group: TaskGroup, protocol: str) -> Iterator[str]:
    """What is wrong with the arrays of a run's policies: missing and foreign policies, then their arrays."""
    parts, foreign = _split(arrays, policy_keys(protocol, group))
    for name in foreign[:3]:
        yield f"The array {name!r} belongs to no stage of the {protocol} protocol."
    for key, part in parts.items():
        where = prefix(key)[:-1]
        if not part:
            yield f"The policy of {where} is missing."
        else:
            yield from (f"{where}: {error}" for error in array_errors(part))


def _split(arrays: Arrays, keys: list[Key]) -> tuple[dict[Key, dict[str, Array]], list[str]]:
    """The arrays of each policy by their own names, and the full names of the others."""
    parts: dict[Key, dict[str, Array]] = {key: {} for key in keys}
    by_prefix, foreign = {prefix(key): key for key in keys}, []
    for full, values in arrays.items():
        start, _, name = full.rpartition("/")
        key = by_prefix.get(f"{start}/")
        if key is None:
            foreign.append(full)
        else:
            parts[key][name] = values
    return parts, foreign


def policies_of(arrays: Arrays, group: TaskGroup, protocol: str) -> dict[Key, Policy]:
    """The policies of a run by stage and, in the single protocol, task name (else None).

    Raises:
        BenchError: an array is missing, foreign or of another shape or kind.
    """
    if error := next(run_errors(arrays, group, protocol), ""):
        raise BenchError("bad-policy", error, hint=HINT)
    parts, _ = _split(arrays, policy_keys(protocol, group))
    return {key: Policy.from_arrays(part) for key, part in parts.items()}


def read_policies(folder: Path, group: TaskGroup, protocol: str, run: int) -> dict[Key, Policy]:
    """The policies of a run by stage and, in the single protocol, task name (else None).

    Args:
        folder: the submission.
        group: the group.
        protocol: one of ``PROTOCOLS``.
        run: the run.

    Raises:
        BenchError: there are none, or they do not fit the group and the protocol.
    """
    return policies_of(read_arrays(folder, group, protocol, run), group, protocol)
