"""The simulation state as named arrays: taken out, and put back so that the continuation is the same."""

from __future__ import annotations

from collections.abc import Mapping

import mujoco
import numpy as np
from numpy.typing import NDArray

from gym_extensions.errors import BenchError

State = dict[str, NDArray[np.float64]]
DERIVED = "derived_"
"""Prefix of values that follow from the others or from the reset seed: a trace leaves them out."""

INTEGRATED = ("qpos", "qvel", "qacc_warmstart")
MOCAP = ("mocap_pos", "mocap_quat")


def take(data: mujoco.MjData, lagging: tuple[str, ...]) -> State:
    """A copy of what determines the next step, and of the lagging quantities that its reward reads."""
    names = INTEGRATED + (MOCAP if data.mocap_pos.size else ())
    state: State = {name: np.array(getattr(data, name), dtype=np.float64) for name in names}
    state["time"] = np.array(data.time)
    return state | {DERIVED + name: np.array(getattr(data, name)) for name in lagging}


def check(given: Mapping[str, NDArray[np.float64]], expected: State, where: str) -> State:
    """The given state as float64 arrays; derived values may be absent.

    Raises:
        BenchError: a value is missing, unknown, of another shape or not finite.
    """
    for name in sorted(expected.keys() | given.keys()):
        if name not in expected:
            raise BenchError("bad-state", f"The state holds an unknown {name!r}.", where)
        if name not in given:
            if name.startswith(DERIVED):
                continue
            raise BenchError("bad-state", f"The state lacks {name!r}.", where)
        shape, wanted = np.shape(given[name]), expected[name].shape
        if shape != wanted:
            raise BenchError("bad-state", f"The state's {name!r} has shape {shape}, not {wanted}.", where)
        if not np.isfinite(given[name]).all():
            raise BenchError("bad-state", f"The state's {name!r} holds a value that is not finite.", where)
    return {name: np.array(value, dtype=np.float64) for name, value in given.items()}


def put(model: mujoco.MjModel, data: mujoco.MjData, state: State, lagging: tuple[str, ...]) -> None:
    """Writes a checked state into the simulation and recomputes what follows from it."""
    data.time = float(state["time"])
    for name in ("qpos", "qvel", *(MOCAP if data.mocap_pos.size else ())):
        getattr(data, name)[:] = state[name]
    mujoco.mj_forward(model, data)
    data.qacc_warmstart[:] = state["qacc_warmstart"]
    for name in lagging:
        if DERIVED + name in state:
            getattr(data, name)[:] = state[DERIVED + name]
