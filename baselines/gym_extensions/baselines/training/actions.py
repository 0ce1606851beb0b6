"""An agent's actions as the environment receives them: checked and clipped to the action space."""

from __future__ import annotations

from typing import Any

import numpy as np

from gym_extensions.baselines.agent import Array, VectorEnv
from gym_extensions.errors import BenchError

NUMERIC_KINDS = "biuf"
"""Allowed kinds of arrays: booleans, integers, floats."""


def clip_actions(actions: object, env: VectorEnv, where: str) -> Array:
    """Clips actions to the action space and casts them to its dtype (float32).

    Args:
        actions: the agent's actions.
        env: the vector environment that receives them.
        where: the call that they come from, for error messages.

    Returns:
        Actions (num_envs, …).

    Raises:
        BenchError: the actions are not an array of finite numbers of shape (num_envs, …).
    """
    space = env.single_action_space
    shape = (env.num_envs, *(space.shape or ()))
    array = _to_array(actions)
    if array is None or array.dtype.kind not in NUMERIC_KINDS or array.shape != shape:
        message = f"The agent returned {_describe(actions, array)} as actions."
        hint = f"Return an array of numbers of shape {shape}, one row per environment."
        raise BenchError("bad-actions", message, where, hint)
    if not np.isfinite(array).all():
        index = tuple(np.argwhere(~np.isfinite(array))[0].tolist())
        message = f"The agent returned {array[index]} as an action, in the row of environment {index[0]}."
        raise BenchError("bad-actions", message, where, "Return finite numbers.")
    low, high, dtype = getattr(space, "low", None), getattr(space, "high", None), space.dtype
    return array if low is None else np.clip(array, low, high).astype(dtype, copy=False)


def _to_array(actions: Any) -> Array | None:
    try:
        return np.asarray(actions)
    except (TypeError, ValueError, RuntimeError):  # a ragged list, or a tensor on another device
        return None


def _describe(actions: object, array: Array | None) -> str:
    if array is not None and array.shape:
        return f"an array of shape {array.shape} and dtype {array.dtype}"
    return f"a value of type {type(actions).__name__}"
