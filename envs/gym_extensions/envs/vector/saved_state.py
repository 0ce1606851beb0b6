"""Saved states that are given back: the rows that a lot's lanes need, checked."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from gym_extensions.envs.seeding import WHERE
from gym_extensions.envs.state import DERIVED
from gym_extensions.envs.vector.physics import Array, Lanes
from gym_extensions.errors import BenchError


def rows_for(states: Mapping[str, Array], rows: Lanes, expected: Mapping[str, Array]) -> dict[str, Array]:
    """The chosen rows of every expected name, float64; derived names may be absent.

    Args:
        states: arrays by name, a row a lane.
        rows: which of their rows.
        expected: what the lot itself saves, for names and shapes.

    Raises:
        BenchError: a name is missing, a value has another shape or is not finite.
    """
    found: dict[str, Array] = {}
    for name, own in expected.items():
        if name not in states:
            if name.startswith(DERIVED):
                continue
            raise BenchError("bad-state", f"The states lack {name!r}.", WHERE)
        value = np.asarray(states[name], np.float64)
        if value.shape[1:] != own.shape[1:] or len(value) <= rows.max():
            wanted = ", ".join(map(str, ("lanes", *own.shape[1:])))
            message = f"The states' {name!r} has shape {value.shape}, not ({wanted})."
            raise BenchError("bad-state", message, WHERE)
        found[name] = value[rows]
        if not np.isfinite(found[name]).all():
            raise BenchError("bad-state", f"The states' {name!r} holds a value that is not finite.", WHERE)
    return found


def check_names(states: Mapping[str, Array], known: set[str]) -> None:
    """Raises ``BenchError`` for a name that no lane's task saves."""
    for name in sorted(states.keys() - known):
        raise BenchError("bad-state", f"The states hold an unknown {name!r}.", WHERE)
