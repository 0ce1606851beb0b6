"""What is wrong with the arrays of a trace, before it is replayed."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.task import Task
from gym_extensions.rollouts.problem import quote
from gym_extensions.rollouts.traces import (
    DTYPES,
    SEGMENT_RETURNS,
    SEGMENT_STEPS,
    STATE,
    STATE_DTYPE,
    lengths,
)

Arrays = Mapping[str, NDArray[Any]]
ROUNDING = 1e-12
"""Largest relative difference between the sum of all rewards and the sum of the segments' sums."""


def trace_errors(arrays: Arrays, task: Task, length: int, return_: float) -> Iterator[str]:
    """What is wrong with the arrays of a trace, a sentence each.

    Args:
        arrays: the arrays by name.
        task: the task of the episode.
        length: number of steps in the log.
        return_: the return in the log.
    """
    missing = [name for name in DTYPES if name not in arrays]
    if missing:
        yield f"The array {missing[0]!r} is missing."
        return
    segment = task.body.segments
    steps = arrays[SEGMENT_STEPS].tolist()
    if steps != segment.steps:
        yield f"{SEGMENT_STEPS!r} is {quote(steps)}; it is {segment.steps} for {task.base}."
    expected = lengths(length, segment.steps)
    for name, values in arrays.items():
        if name == SEGMENT_STEPS:
            continue
        key = STATE if name.startswith(STATE) else name
        if key not in expected:
            yield f"Unexpected array {quote(name)}."
            continue
        yield from _array_errors(name, values, DTYPES.get(key, STATE_DTYPE), expected[key])
    if arrays[SEGMENT_RETURNS].ndim != 1:
        return
    total = _sum(arrays[SEGMENT_RETURNS].tolist())
    tolerance = max(segment.tolerance, ROUNDING)
    if not abs(total - return_) <= tolerance * max(1.0, abs(return_)):
        yield f"The segment returns sum to {total!r}; the return in the log is {return_!r}."


def _array_errors(name: str, values: NDArray[Any], dtype: type[np.generic], length: int) -> Iterator[str]:
    is_flat = name == SEGMENT_RETURNS
    if values.dtype != dtype or values.shape[:1] != (length,) or (is_flat and values.ndim != 1):
        shape = f"({length},)" if is_flat else f"({length}, …)"
        actual = f"{values.dtype} of shape {quote(values.shape)}"
        yield f"{quote(name)} is {actual}; expected {np.dtype(dtype)} of shape {shape}."
    elif not np.isfinite(values).all():
        yield f"{quote(name)} contains a value that is not finite."


def _sum(returns: list[float]) -> float:
    try:
        return math.fsum(returns)
    except OverflowError:
        return math.inf
