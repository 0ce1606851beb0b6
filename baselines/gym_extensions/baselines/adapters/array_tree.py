"""Nested dicts and lists with tensors and arrays, as flat arrays that npz stores without pickle."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import numpy as np
import torch

from gym_extensions.baselines.agent import Array


def to_arrays(value: Any) -> dict[str, Array]:
    """A tree of dicts, lists, tuples, tensors, arrays and plain values as flat arrays without pickle.

    The array ``tree`` is the tree as JSON text, in which a number stands for each array.
    """
    arrays: list[Array] = []

    def encode(value: Any) -> Any:
        if isinstance(value, torch.Tensor):
            arrays.append(value.detach().numpy())
            return {"tensor": len(arrays) - 1}
        if isinstance(value, np.ndarray | np.generic):
            arrays.append(np.asarray(value))
            return {"array": len(arrays) - 1}
        if isinstance(value, dict):
            return {"dict": [[key, encode(item)] for key, item in value.items()]}
        if isinstance(value, list | tuple):
            return {type(value).__name__: [encode(item) for item in value]}
        return value

    tree = json.dumps(encode(value))
    return {"tree": np.array(tree), **{f"array{i}": array for i, array in enumerate(arrays)}}


def from_arrays(arrays: dict[str, Array]) -> Any:
    """The tree of :func:`to_arrays`."""
    decoders: dict[str, Callable[[Any], Any]] = {
        "tensor": lambda i: torch.from_numpy(arrays[f"array{i}"].copy()),
        "array": lambda i: arrays[f"array{i}"],
        "dict": lambda items: {key: decode(item) for key, item in items},
        "list": lambda items: [decode(item) for item in items],
        "tuple": lambda items: tuple(decode(item) for item in items),
    }

    def decode(value: Any) -> Any:
        if not isinstance(value, dict):
            return value
        ((kind, content),) = value.items()
        return decoders[kind](content)

    return decode(json.loads(str(arrays["tree"])))
