"""Infos of vector environments in Gymnasium's form: one array per key, and ``_key`` for who has it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gym_extensions.envs.protocols import Flags, Indices

Part = tuple[Indices, dict[str, NDArray[Any]]]
"""Environments with the same keys, in order, and their values by key, one row per environment."""


def gather(parts: Sequence[Part], everyone: Flags) -> dict[str, Any]:
    """Returns the infos of all environments.

    Args:
        parts: the environments and their values.
        everyone: ``(num_envs,)``, all true; it is every mask if there is one part.
    """
    if len(parts) != 1:
        return combine(parts, len(everyone))
    infos: dict[str, Any] = {}
    for key, rows in parts[0][1].items():
        infos[key] = rows
        infos["_" + key] = everyone
    return infos


def select(parts: Iterable[Part], chosen: Flags) -> list[Part]:
    """Returns the parts without the environments that are not chosen, ``(num_envs,)``."""
    selected: list[Part] = []
    for members, values in parts:
        keep = chosen[members]
        if keep.any():
            selected.append((members[keep], {key: rows[keep] for key, rows in values.items()}))
    return selected


def combine(parts: Iterable[Part], num_envs: int) -> dict[str, Any]:
    """Returns the infos of parts of the environments, with zeros where an environment lacks a key."""
    infos: dict[str, Any] = {}
    for members, values in parts:
        for key, rows in values.items():
            if key not in infos:
                infos[key] = np.zeros((num_envs, *rows.shape[1:]), rows.dtype)
                infos[f"_{key}"] = np.zeros(num_envs, np.bool_)
            infos[key][members] = rows
            infos[f"_{key}"][members] = True
    return infos
