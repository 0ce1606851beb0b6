"""Saving and restoring the state of one simulation as named arrays, bit for bit."""

from __future__ import annotations

from collections.abc import Mapping

import mujoco
import numpy as np
from numpy.typing import NDArray

from gym_extensions.errors import BenchError

State = dict[str, NDArray[np.float64]]
DERIVED = "derived_"
"""Prefix of values that follow from the others or from the reset seed. Traces do not store them."""

INTEGRATED = ("qpos", "qvel", "qacc_warmstart")
MOCAP = ("mocap_pos", "mocap_quat")


def take(data: mujoco.MjData, one_step_behind: tuple[str, ...]) -> State:
    """Copies the fields that determine the next step, and the fields that its reward reads one step late."""
    names = INTEGRATED + (MOCAP if data.mocap_pos.size else ())
    state: State = {name: np.array(getattr(data, name), dtype=np.float64) for name in names}
    state["time"] = np.array(data.time)
    return state | {DERIVED + name: np.array(getattr(data, name)) for name in one_step_behind}


def check(saved: Mapping[str, NDArray[np.float64]], expected: State, where: str) -> State:
    """Returns a saved state as float64 arrays.

    Derived values may be absent.

    Raises:
        BenchError: a value is missing, unknown, of another shape or not finite.
    """
    for name in sorted(expected.keys() | saved.keys()):
        if name not in expected:
            raise BenchError("bad-state", f"The state has an unknown entry {name!r}.", where)
        if name not in saved:
            if name.startswith(DERIVED):
                continue
            raise BenchError("bad-state", f"The state has no entry {name!r}.", where)
        shape, expected_shape = np.shape(saved[name]), expected[name].shape
        if shape != expected_shape:
            message = f"The state's {name!r} has shape {shape}; expected {expected_shape}."
            raise BenchError("bad-state", message, where)
        if not np.isfinite(saved[name]).all():
            raise BenchError("bad-state", f"The state's {name!r} has a value that is not finite.", where)
    return {name: np.array(value, dtype=np.float64) for name, value in saved.items()}


def put(model: mujoco.MjModel, data: mujoco.MjData, state: State, one_step_behind: tuple[str, ...]) -> None:
    """Writes a checked state into the simulation and recomputes derived fields."""
    data.time = float(state["time"])
    for name in ("qpos", "qvel", *(MOCAP if data.mocap_pos.size else ())):
        getattr(data, name)[:] = state[name]
    mujoco.mj_forward(model, data)
    data.qacc_warmstart[:] = state["qacc_warmstart"]
    for name in one_step_behind:
        if DERIVED + name in state:
            getattr(data, name)[:] = state[DERIVED + name]
