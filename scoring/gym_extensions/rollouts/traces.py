"""A trace holds the recorded actions of an episode and the states that replay starts segments from."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gym_extensions.rollouts.safe_npz import npz_bytes

Array = NDArray[Any]

ACTIONS = "actions"
SEGMENT_STEPS = "segment_steps"
SEGMENT_RETURNS = "segment_returns"
STATE = "state_"
"""Prefix of the arrays that hold states."""
DERIVED = "derived_"
"""Prefix of state names that a trace leaves out, because replay's warm-up step recomputes them."""
DTYPES: dict[str, type[np.generic]] = {
    ACTIONS: np.float32,
    SEGMENT_STEPS: np.int64,
    SEGMENT_RETURNS: np.float64,
}
STATE_DTYPE: type[np.generic] = np.float64


@dataclass(frozen=True)
class Trace:
    """One episode of L steps, cut into ⌈L/K⌉ segments of K steps.

    ``actions`` (L, …) float32, as applied; ``segment_returns`` (⌈L/K⌉,) float64; ``states`` by name,
    (⌈L/K⌉ − 1, …) float64: the state one step before each segment but the first, at t = K−1, 2K−1, …
    """

    actions: Array
    segment_steps: int
    segment_returns: Array
    states: Mapping[str, Array]


def lengths(steps: int, segment_steps: int) -> dict[str, int]:
    """First dimension of each array of an episode. ``STATE`` represents every state."""
    segments = -(-steps // segment_steps)
    return {ACTIONS: steps, SEGMENT_RETURNS: segments, STATE: segments - 1}


def is_recorded(state_name: str) -> bool:
    """Whether a trace holds the state of that name."""
    return not state_name.startswith(DERIVED)


def cut(actions: Array, rewards: Array, states: Sequence[Mapping[str, Array]], segment_steps: int) -> Trace:
    """The trace of an episode.

    Args:
        actions: (L, …), as applied.
        rewards: (L,).
        states: the state at t = K−1, 2K−1, …; more than the episode needs are ignored.
        segment_steps: K.
    """
    starts = range(0, len(rewards), segment_steps)
    returns = [math.fsum(rewards[start : start + segment_steps]) for start in starts]
    needed = states[: len(returns) - 1]
    names = sorted(filter(is_recorded, needed[0])) if needed else []
    rows = {name: np.stack([np.asarray(state[name], STATE_DTYPE) for state in needed]) for name in names}
    return Trace(
        np.asarray(actions, DTYPES[ACTIONS]),
        segment_steps,
        np.array(returns, DTYPES[SEGMENT_RETURNS]),
        rows,
    )


def trace_arrays(trace: Trace) -> dict[str, Array]:
    """The arrays of the .npz file by name."""
    return {
        ACTIONS: trace.actions,
        SEGMENT_STEPS: np.array(trace.segment_steps, DTYPES[SEGMENT_STEPS]),
        SEGMENT_RETURNS: trace.segment_returns,
        **{f"{STATE}{name}": values for name, values in trace.states.items()},
    }


def trace_bytes(trace: Trace) -> bytes:
    """The content of the .npz file. Equal traces give equal bytes."""
    return npz_bytes(trace_arrays(trace))
