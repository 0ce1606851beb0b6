"""Checks of saved states of many environments before they are restored."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from gym_extensions.envs.batch.seeding import WHERE
from gym_extensions.envs.protocols import Array, Indices, States
from gym_extensions.envs.state import DERIVED
from gym_extensions.errors import BenchError


def rows_for(states: States, rows: Indices, expected: Mapping[str, Array]) -> dict[str, Array]:
    """Returns the chosen rows of every expected name, float64.

    Derived names may be absent.

    Args:
        states: arrays by name, one row per environment.
        rows: which of their rows.
        expected: what the environments themselves save, for names and shapes.

    Raises:
        BenchError: a name is missing, or a value has another shape or is not finite.
    """
    selected: dict[str, Array] = {}
    for name, template in expected.items():
        if name not in states:
            if name.startswith(DERIVED):
                continue
            raise BenchError("bad-state", f"The states have no entry {name!r}.", WHERE)
        value = np.asarray(states[name], np.float64)
        if value.ndim == 0 or value.shape[1:] != template.shape[1:] or len(value) <= rows.max():
            shape = ", ".join(map(str, ("num_envs", *template.shape[1:])))
            message = f"The states' {name!r} has shape {value.shape}; expected ({shape})."
            raise BenchError("bad-state", message, WHERE)
        selected[name] = value[rows]
        if not np.isfinite(selected[name]).all():
            raise BenchError("bad-state", f"The states' {name!r} has a value that is not finite.", WHERE)
    return selected


def check_rows(states: States, count: int) -> None:
    """Raises ``BenchError`` unless every array has one row per restored environment."""
    for name, value in states.items():
        if np.ndim(value) > 0 and len(value) != count:
            message = f"The states' {name!r} has {len(value)} rows; expected {count}."
            raise BenchError("bad-state", message, WHERE, "Give one row per restored environment.")


def check_names(states: States, expected: set[str]) -> None:
    """Raises ``BenchError`` for a name that no environment saves."""
    for name in sorted(states.keys() - expected):
        raise BenchError("bad-state", f"The states have an unknown entry {name!r}.", WHERE)
