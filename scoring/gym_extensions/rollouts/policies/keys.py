"""The arrays of a policy file: their names, kinds and shapes."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal

from gym_extensions.rollouts.policies.activations import ACTIVATIONS

FORMAT = 1
HEADS = ("deterministic", "gaussian", "uniform")
"""How a policy selects actions."""
FLOATS = ("float32", "float64")
LAYER = re.compile(r"(weight|bias|mask)_(0|[1-9][0-9]?)")
"""The name of an array of a layer; its groups are the kind of array and the layer, from 0."""
LAYER_FIELDS = {"weights": "weight", "biases": "bias", "masks": "mask"}
"""The prefix of the arrays that a field of :class:`~gym_extensions.rollouts.policies.Policy` becomes."""

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
    "head": Key("name", is_required=True, choices=HEADS),
    "activation": Key("name", is_required=True, choices=tuple(ACTIVATIONS)),
    "output_activation": Key("name", is_required=True, choices=tuple(ACTIVATIONS)),
    "squash": Key("name", is_required=True, choices=("linear", "tanh")),
    "observation_dtype": Key("name", is_required=True, choices=FLOATS),
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
