"""Hyperparameters of any type as values that ``submission.toml`` can store."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from gym_extensions.baselines.agent import Setting
from gym_extensions.rollouts.manifest_values import LONG, hyperparameter_error

ADDRESS = re.compile(r" at 0x[0-9a-fA-F]+")


def to_manifest_value(value: Any) -> Setting:
    """A plain value unchanged (a tuple as a list), any other value as text, cut at the manifest's limit.

    The text of a class or function is its qualified name, so two lambdas of one scope have the same text. The
    text contains no module name and no memory address: it is the same in every process.
    """
    if not hyperparameter_error(value):
        plain: Setting = list(value) if isinstance(value, tuple) else value
        return plain
    return _text(value)[:LONG]


def _text(value: Any) -> str:
    if isinstance(value, np.ndarray | np.generic):
        return _text(value.tolist())
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{_text(key)}: {_text(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(_text, value)) + "]"
    if isinstance(value, set | frozenset):
        return "{" + ", ".join(sorted(map(_text, value))) + "}"
    kind: Any = type(value)
    if hasattr(value, "__qualname__"):
        return str(value.__qualname__)
    return str(kind.__qualname__) if kind.__repr__ is object.__repr__ else ADDRESS.sub("", repr(value))
