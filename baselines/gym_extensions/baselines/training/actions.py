"""An agent's actions as they are applied: of the right shape, inside the box."""

from __future__ import annotations

from typing import Any

import numpy as np

from gym_extensions.baselines.agent import Array, VectorEnv
from gym_extensions.errors import BenchError

NUMBERS = "biuf"
"""Kinds of arrays that are actions: truth values, whole numbers, floats."""


def clipped(actions: object, env: VectorEnv, where: str) -> Array:
    """The actions inside the action space, in its own type (float32).

    Args:
        actions: what the agent gave.
        env: whose lanes they are for.
        where: the method that they came from, for an error.

    Raises:
        BenchError: they are no array of numbers, a row a lane.
    """
    space = env.single_action_space
    shape = (env.num_envs, *(space.shape or ()))
    found = _array(actions)
    if found is None or found.dtype.kind not in NUMBERS or found.shape != shape:
        message = f"The agent gave {_described(actions, found)} as its actions."
        hint = f"Give an array of numbers of shape {shape}, a row a lane."
        raise BenchError("bad-actions", message, where, hint)
    low, high, kind = getattr(space, "low", None), getattr(space, "high", None), space.dtype
    return found if low is None else np.clip(found, low, high).astype(kind, copy=False)


def _array(actions: Any) -> Array | None:
    try:
        return np.asarray(actions)
    except (TypeError, ValueError, RuntimeError):  # rows of several lengths; a tensor elsewhere
        return None


def _described(actions: object, found: Array | None) -> str:
    if found is not None and found.shape:
        return f"an array of shape {found.shape} and type {found.dtype}"
    return f"a value of kind {type(actions).__name__}"
