"""Layers of torch and flax networks as weights, biases and the name of an activation."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from torch import nn

Parts = dict[str, Any]

TORCH_ACTIVATIONS: dict[type[nn.Module], str] = {
    nn.Identity: "linear",
    nn.Tanh: "tanh",
    nn.ReLU: "relu",
    nn.LeakyReLU: "leaky_relu",
    nn.ELU: "elu",
    nn.SiLU: "silu",
}
"""The names that a policy file has for torch's activations, with torch's default arguments."""
FLAX_ACTIVATIONS = ("tanh", "relu", "leaky_relu", "elu", "silu")
"""Flax's functions with the same names."""


def torch_layers(modules: Sequence[nn.Module]) -> Parts:
    """The layers of linear modules with activations between them, as arguments of a ``Policy``.

    Raises:
        TypeError: a module of another kind, or different activations.
    """
    linear = [module for module in modules if isinstance(module, nn.Linear)]
    between = [module for module in modules if not isinstance(module, nn.Linear)]
    names = {_torch_activation(module) for module in between}
    if len(names) > 1 or len(between) != len(linear) - 1 or not isinstance(modules[-1], nn.Linear):
        raise TypeError("its layers do not alternate with one kind of activation")
    return {
        "weights": tuple(module.weight.detach().numpy().T for module in linear),
        "biases": tuple(module.bias.detach().numpy() for module in linear),
        "activation": names.pop() if names else "linear",
    }


def _torch_activation(module: nn.Module) -> str:
    name = TORCH_ACTIVATIONS.get(type(module))
    # The text of an activation shows its arguments, such as the slope of a LeakyReLU.
    if name is None or repr(module) != repr(type(module)()):
        raise TypeError(f"it contains {module}")
    return name


def flax_layers(parameters: Mapping[str, Any], names: Sequence[str], activation: Callable[..., Any]) -> Parts:
    """The dense layers of these names, as arguments of a ``Policy``.

    Raises:
        TypeError: an activation of another kind.
    """
    name = getattr(activation, "__name__", type(activation).__name__)
    if name not in FLAX_ACTIVATIONS:
        raise TypeError(f"its activation is {name}")
    return {
        "weights": tuple(np.asarray(parameters[layer]["kernel"]) for layer in names),
        "biases": tuple(np.asarray(parameters[layer]["bias"]) for layer in names),
        "activation": name,
    }
