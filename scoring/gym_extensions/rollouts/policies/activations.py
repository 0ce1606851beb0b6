"""The activations of a policy, by name."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
LEAK = 0.01
"""Slope of ``leaky_relu`` below 0: the default of PyTorch and JAX."""


def _elu(values: Array) -> Array:
    return np.where(values > 0, values, np.expm1(np.minimum(values, 0)))


def _leaky_relu(values: Array) -> Array:
    return np.where(values > 0, values, values.dtype.type(LEAK) * values)


def _silu(values: Array) -> Array:
    # The logistic function as a tanh, which does not overflow.
    half = values.dtype.type(0.5)
    result: Array = values * (half * np.tanh(half * values) + half)
    return result


ACTIVATIONS: dict[str, Callable[[Array], Array]] = {
    "linear": lambda values: values,
    "tanh": np.tanh,
    "relu": lambda values: np.maximum(values, 0),
    "leaky_relu": _leaky_relu,
    "elu": _elu,
    "silu": _silu,
}
"""Functions of one float array, which keep its type."""
