"""What replay needs of an episode: its actions, and short segments that restart from recorded states."""

from __future__ import annotations

import io
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]


LEFT_OUT = "derived_"
"""Saved names that begin so are recomputed by replay's warm-up step."""


@dataclass(frozen=True)
class Trace:
    """One episode of L steps cut into ⌈L/K⌉ segments.

    ``actions`` (L, …) float32 as applied; ``segment_returns`` (⌈L/K⌉,) float64; ``states`` by name, a row for
    each segment but the first: the state one step before it starts, at t = K−1, 2K−1, …
    """

    actions: Array
    segment_steps: int
    segment_returns: Array
    states: Mapping[str, Array]


def cut(actions: Array, rewards: Array, states: Sequence[Mapping[str, Array]], segment_steps: int) -> Trace:
    """The trace of an episode, from its actions and rewards and the states at t = K−1, 2K−1, … (or more)."""
    starts = range(0, len(rewards), segment_steps)
    returns = np.array([math.fsum(rewards[at : at + segment_steps]) for at in starts], np.float64)
    kept = states[: len(returns) - 1]
    names = sorted(name for name in (states[0] if states else ()) if not name.startswith(LEFT_OUT))
    rows = {name: np.stack([np.asarray(state[name], np.float64) for state in kept]) for name in names if kept}
    return Trace(np.asarray(actions, np.float32), segment_steps, returns, rows)


def trace_bytes(trace: Trace) -> bytes:
    """The npz file's content: the same bytes for the same trace (numpy dates every member 1980-01-01)."""
    content = io.BytesIO()
    states = {f"state_{name}": values for name, values in trace.states.items()}
    np.savez_compressed(
        content,
        allow_pickle=False,
        actions=trace.actions,
        segment_steps=np.array(trace.segment_steps, np.int64),
        segment_returns=trace.segment_returns,
        **states,
    )
    return content.getvalue()
