"""The arrays of a policy: their names, kinds and shapes, and what is wrong with them."""

import itertools
import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from gym_extensions.errors import BenchError
from gym_extensions.submissions.problem import quote

Array = NDArray[Any]
Arrays = Mapping[str, Array]
ACTIVATIONS = ("linear", "tanh", "relu", "leaky_relu", "elu", "silu")
"""Functions of one number."""
LEAK = 0.01
"""Slope of ``leaky_relu`` below 0: the default of PyTorch and JAX."""
FORMAT = 1
LAYER = re.compile(r"(weight|bias|mask)_(0|[1-9][0-9]?)")
"""The name of an array of a layer; its groups are the kind of array and the layer, from 0."""
LAYER_FIELDS = {"weights": "weight", "biases": "bias", "masks": "mask"}
"""The prefix of the arrays that a field of a ``Policy`` becomes."""

Kind = Literal["format", "name", "float", "mask"]


@dataclass(frozen=True)
class Key:
    """An array of a policy file.

    Args:
        kind: ``name`` is text as ASCII bytes, ``float`` is float32 or float64, ``mask`` is bool.
        shape: the names of the dimensions, without the axis of tasks: ``o`` is the number of observations,
            ``a`` of actions, ``h`` of inputs of the last layer, ``i`` and ``j`` of inputs and outputs.
        is_required: whether every file has it.
        has_tasks: whether it may have a leading axis of tasks.
        is_positive: whether all values are above 0.
        choices: the allowed names.
    """

    kind: Kind
    shape: tuple[str, ...] = ()
    is_required: bool = False
    has_tasks: bool = False
    is_positive: bool = False
    choices: tuple[str, ...] = ()


KEYS: dict[str, Key] = {
    "format": Key("format", is_required=True),
    "head": Key("name", is_required=True, choices=("deterministic", "gaussian", "uniform")),
    "activation": Key("name", is_required=True, choices=ACTIVATIONS),
    "output_activation": Key("name", is_required=True, choices=ACTIVATIONS),
    "squash": Key("name", is_required=True, choices=("linear", "tanh")),
    "observation_dtype": Key("name", is_required=True, choices=("float32", "float64")),
    "observation_mean": Key("float", ("o",), has_tasks=True),
    "observation_scale": Key("float", ("o",), has_tasks=True, is_positive=True),
    "observation_clip": Key("float", is_positive=True),
    "weight": Key("float", ("i", "j"), has_tasks=True),
    "bias": Key("float", ("j",), has_tasks=True),
    "mask": Key("mask", ("i", "j"), has_tasks=True),
    "log_sigma": Key("float", ("a",), has_tasks=True),
    "log_sigma_weight": Key("float", ("h", "a"), has_tasks=True),
    "log_sigma_clip": Key("float", ("2",)),
    "action_offset": Key("float", ("a",), is_required=True),
    "action_scale": Key("float", ("a",), is_required=True, is_positive=True),
}
"""By name; the arrays of layer 0 are ``weight_0``, ``bias_0`` and ``mask_0``, and so on."""


def key_of(name: str) -> Key | None:
    """The key of an array by its name in the file, or None if there is none."""
    if match := LAYER.fullmatch(name):
        return KEYS[match[1]]
    return None if name in LAYER_FIELDS.values() else KEYS.get(name)


NEEDED = {
    "observation_mean": "observation_scale",
    "observation_scale": "observation_mean",
    "log_sigma_weight": "log_sigma",
}
"""The array that another one needs."""


def text_of(values: Array) -> str:
    """The text of an array of ASCII bytes."""
    return values.tobytes().decode("ascii", "replace")


def array_errors(arrays: Arrays) -> Iterator[str]:
    """The errors of the first kind of check that reports any: names, types, shapes, values."""
    for check in (_name_errors, _type_errors, _shape_errors, _value_errors):
        errors = list(check(arrays))
        yield from errors
        if errors:
            return


def _name_errors(arrays: Arrays) -> Iterator[str]:
    for name in arrays:
        if key_of(name) is None:
            yield f"Unexpected array {quote(name)}."
    layers = 1 + max((int(match[2]) for match in map(LAYER.fullmatch, arrays) if match), default=-1)
    required = [name for name, key in KEYS.items() if key.is_required]
    required += [f"{part}_{layer}" for layer in range(layers) for part in ("weight", "bias")]
    required += [needed for name, needed in NEEDED.items() if name in arrays]
    for name in dict.fromkeys(required):
        if name not in arrays:
            yield f"The array {name!r} is missing."


def _type_errors(arrays: Arrays) -> Iterator[str]:
    dtypes = {"format": "int64", "name": "uint8", "mask": "bool", "float": "float32 or float64"}
    for name, values in arrays.items():
        key = key_of(name) or Key("float")
        expected = dtypes[key.kind]
        if not (values.dtype.isnative and values.dtype.name in expected.split(" or ")):
            yield f"{name!r} is {values.dtype}; expected {expected}."
        elif key.kind == "name" and text_of(values) not in key.choices:
            yield f"{name!r} is {quote(text_of(values))}; expected one of {', '.join(key.choices)}."
        elif key.kind == "format" and values.tolist() != FORMAT:
            yield f"The format is {quote(values.tolist())}; expected {FORMAT}."


def _shape_errors(arrays: Arrays) -> Iterator[str]:
    sizes = {"2": 2, "a": arrays["action_offset"].size}
    if "weight_0" in arrays and arrays["weight_0"].ndim in (2, 3):
        sizes["o"] = arrays["weight_0"].shape[-2]
    elif "observation_mean" in arrays:
        sizes["o"] = arrays["observation_mean"].shape[-1] if arrays["observation_mean"].ndim else 0
    widths: list[int] = []  # the inputs of each layer, then the number of actions, which are the last outputs
    while (weights := arrays.get(f"weight_{len(widths)}")) is not None:
        widths.append(weights.shape[-2] if weights.ndim > 1 else 0)
    widths.append(sizes["a"])
    sizes["h"] = widths[-2] if len(widths) > 1 else sizes.get("o", 0)
    rows: dict[str, int] = {}
    for name, values in arrays.items():
        key, match = key_of(name), LAYER.fullmatch(name)
        if key is None or key.kind in ("name", "format"):
            continue
        if match:
            sizes["i"], sizes["j"] = widths[int(match[2])], widths[int(match[2]) + 1]
        expected = tuple(sizes[dimension] for dimension in key.shape)
        has_rows = key.has_tasks and values.ndim == len(expected) + 1
        if 0 in values.shape:
            yield f"{name!r} is empty."
        elif (values.shape[1:] if has_rows else values.shape) != expected:
            yield f"{name!r} has the shape {quote(values.shape)}; expected {expected}."
        elif has_rows:
            rows[name] = len(values)
    for first, second in itertools.pairwise(rows):
        if rows[first] != rows[second]:
            yield f"{second!r} has rows for {rows[second]} tasks; {first!r} has {rows[first]}."


def _value_errors(arrays: Arrays) -> Iterator[str]:
    for name, values in arrays.items():
        key = key_of(name)
        if key is None or key.kind != "float":
            continue
        if not np.isfinite(values).all():
            yield f"{name!r} contains a value that is not finite."
        elif key.is_positive and not (values > 0).all():
            yield f"{name!r} contains a value that is not above 0."
    if text_of(arrays["head"]) == "gaussian" and "log_sigma" not in arrays:
        yield "The array 'log_sigma' is missing; a gaussian policy needs it."
    bounds = arrays.get("log_sigma_clip")
    if bounds is not None and bounds[0] > bounds[1]:
        yield "The lower bound in 'log_sigma_clip' is above the upper bound."


def require_size(observations: Array, inputs: int | None) -> None:
    """Raises ``BenchError`` if observations (n, …) have another size than a policy's inputs; None is any."""
    size = math.prod(observations.shape[1:])
    if inputs not in (None, size):
        message = f"The observations have {size} values; the policy has {inputs} inputs."
        raise BenchError("bad-observations", message, "act()", "Use a policy of the same group.")
