"""The layers of flax networks as the plain arrays of a policy."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from gym_extensions.baselines.adapters.torch_layers import Layers

ACTIVATIONS = ("tanh", "relu", "leaky_relu", "elu", "silu")
"""Flax's functions that a policy names in the same way."""


def flax_layers(
    parameters: Mapping[str, Any], names: Sequence[str], activation: Callable[..., Any]
) -> Layers:
    """The dense layers of these names, as arguments of a ``Policy``.

    Raises:
        TypeError: an activation of another kind.
    """
    name = getattr(activation, "__name__", type(activation).__name__)
    if name not in ACTIVATIONS:
        raise TypeError(f"its activation is {name}")
    return Layers(
        weights=tuple(np.asarray(parameters[layer]["kernel"]) for layer in names),
        biases=tuple(np.asarray(parameters[layer]["bias"]) for layer in names),
        activation=name,
    )
