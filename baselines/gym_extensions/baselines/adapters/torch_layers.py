"""The layers of PyTorch networks as the plain arrays of a policy."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TypedDict

import torch

from gym_extensions.baselines.agent import Array
from gym_extensions.errors import BenchError

ACTIVATIONS: dict[type[torch.nn.Module], str] = {
    torch.nn.Tanh: "tanh",
    torch.nn.ReLU: "relu",
    torch.nn.LeakyReLU: "leaky_relu",
    torch.nn.ELU: "elu",
    torch.nn.SiLU: "silu",
}
"""The name in a policy of each activation, with PyTorch's default settings."""
SUPPORTED = ", ".join(["Linear", *(kind.__name__ for kind in ACTIVATIONS)])


class Layers(TypedDict):
    """Arguments of :class:`gym_extensions.rollouts.policies.Policy`."""

    weights: tuple[Array, ...]
    biases: tuple[Array, ...]
    activation: str


def policy_layers(*modules: torch.nn.Module) -> Layers:
    """The layers of networks that are applied one after the other.

    Args:
        modules: for example the hidden layers and the layer of the mean. Every linear layer but the last is
            followed by the same activation.

    Returns:
        Arguments of a policy; weights are (inputs, outputs), the transpose of PyTorch's.

    Raises:
        BenchError: a module of another kind, another order of layers, or two different activations.

    Example:
        >>> from torch import nn
        >>> layers = policy_layers(nn.Sequential(nn.Linear(3, 8), nn.Tanh()), nn.Linear(8, 2))
        >>> [weights.shape for weights in layers["weights"]], layers["activation"]
        ([(3, 8), (8, 2)], 'tanh')
    """
    leaves = list(_leaves(modules))
    linear = [leaf for leaf in leaves if isinstance(leaf, torch.nn.Linear)]
    activations = {_activation(leaf) for leaf in leaves if not isinstance(leaf, torch.nn.Linear)}
    alternate = [isinstance(leaf, torch.nn.Linear) for leaf in leaves] == [True, False] * (
        len(linear) - 1
    ) + [True]
    if not alternate or len(activations) > 1:
        names = ", ".join(type(leaf).__name__ for leaf in leaves)
        hint = "Give linear layers with the same activation after each but the last."
        raise BenchError("bad-policy", f"The modules are {names}.", "policy_layers()", hint)
    return Layers(
        weights=tuple(_array(layer.weight).T for layer in linear),
        biases=tuple(_bias(layer) for layer in linear),
        activation=activations.pop() if activations else "linear",
    )


def _leaves(modules: tuple[torch.nn.Module, ...]) -> Iterator[torch.nn.Module]:
    for module in modules:
        yield from (leaf for leaf in module.modules() if not any(leaf.children()))


def _activation(leaf: torch.nn.Module) -> str:
    if type(leaf) not in ACTIVATIONS or _arguments(leaf) != _arguments(type(leaf)()):
        message = f"{type(leaf).__name__} cannot be part of a policy."
        raise BenchError("bad-policy", message, "policy_layers()", f"A policy supports {SUPPORTED}.")
    return ACTIVATIONS[type(leaf)]


def _arguments(leaf: torch.nn.Module) -> tuple[object, object]:
    return getattr(leaf, "alpha", None), getattr(leaf, "negative_slope", None)


def _bias(layer: torch.nn.Linear) -> Array:
    has_bias: object = layer.bias
    return _array(layer.bias if has_bias is not None else torch.zeros(layer.out_features))


def _array(values: torch.Tensor) -> Array:
    array: Array = values.detach().cpu().numpy()
    return array
