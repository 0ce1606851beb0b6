"""The check that every action passes before it is applied."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gym_extensions.errors import BenchError


def check_actions(actions: Any, shape: tuple[int, ...], where: str) -> NDArray[Any]:
    """The actions as an array of the given shape, their type and values as they came.

    Args:
        actions: what the agent gave; out-of-range values pass, as in Gymnasium's bodies.
        shape: the shape that is required, ``(act,)`` for one environment, ``(lanes, act)`` for a batch.
        where: the task id, for the error.

    Raises:
        BenchError: another shape, or a value that is not a finite number.
    """
    given = np.asarray(actions)
    if given.shape != shape:
        message = f"The action has shape {given.shape}, not {shape}."
        raise BenchError("bad-action", message, where, "Give one number an actuator.")
    if given.dtype.kind not in "fiu":
        message = f"The action holds {given.dtype} values."
        raise BenchError("bad-action", message, where, "Give floating-point numbers.")
    if not np.isfinite(given).all():
        wrong = np.argwhere(~np.isfinite(given))[0].tolist()
        place, value = ", ".join(map(str, wrong)), given[tuple(wrong)]
        raise BenchError("bad-action", f"action[{place}] is {value}.", where, "Give finite numbers alone.")
    return given
