"""The check of every action before it is applied."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gym_extensions.errors import BenchError


def check_actions(actions: Any, shape: tuple[int, ...], where: str) -> NDArray[Any]:
    """Returns the actions as an array, with dtype and values unchanged.

    Args:
        actions: the agent's actions. Out-of-range values pass, as in Gymnasium's bodies.
        shape: the required shape, ``(act,)``, or ``(num_envs, act)`` in a vector environment.
        where: the task id, for the error.

    Raises:
        BenchError: the shape differs, or a value is not a finite number.
    """
    array = np.asarray(actions)
    if array.shape != shape:
        message = f"The action has shape {array.shape}; expected {shape}."
        raise BenchError("bad-action", message, where, "Give one number per actuator.")
    if array.dtype.kind not in "fiu":
        message = f"The action has dtype {array.dtype}."
        raise BenchError("bad-action", message, where, "Give floating-point numbers.")
    if not np.isfinite(array).all():
        index = np.argwhere(~np.isfinite(array))[0].tolist()
        label, value = ", ".join(map(str, index)), array[tuple(index)]
        raise BenchError("bad-action", f"action[{label}] is {value}.", where, "Give finite numbers.")
    return array
