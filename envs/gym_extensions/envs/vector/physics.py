"""Lanes of one model layout stepped by mujoco.batch, seen as arrays over the lanes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import mujoco
import numpy as np
from mujoco.batch import Batch
from numpy.typing import NDArray

from gym_extensions.envs.state import INTEGRATED, MOCAP

Array = NDArray[np.float64]
Lanes = NDArray[np.intp]


def state_fields(model: mujoco.MjModel) -> tuple[str, ...]:
    """The names of the physics part of a saved state for this model."""
    return (*INTEGRATED, "time", *(MOCAP if model.nmocap else ()))


class Physics(Protocol):
    """Lanes of simulations. Arrays have the lane as first axis and are live: refreshed by every call."""

    def field(self, name: str) -> Array:
        """A field of MjData over all lanes, ``(lanes, …)``; read-only by agreement."""

    def reset(self, lanes: Lanes, state: Mapping[str, Array]) -> None:
        """Resets some lanes to the model's defaults, writes the given rows of the state, runs mj_forward.

        The last only where derived fields are read: it leaves the state as it is.
        """

    def step(self, ctrl: NDArray[Any], lanes: Lanes | None) -> None:
        """Applies ``(all lanes, nu)`` controls for one environment step in the given lanes, or in all."""

    def snapshot(self) -> dict[str, Array]:
        """Copies of the physics state of every lane, by the names of ``state_fields``."""

    def load(self, lanes: Lanes, state: Mapping[str, Array]) -> None:
        """Writes saved rows of every state field into some lanes and recomputes what follows from them."""

    def close(self) -> None:
        """Lets threads and memory go."""


class BatchPhysics:
    """Simulations in mujoco.batch: derived fields are those mj_step leaves, bit for bit."""

    def __init__(
        self, models: Sequence[mujoco.MjModel], frame_skip: int, num_threads: int, fields: Sequence[str]
    ) -> None:
        self._batch = Batch(models[0], len(models), num_threads)
        if any(model is not models[0] for model in models):
            self._batch.set_models(models)
        self._frame_skip = frame_skip
        self._state_fields = state_fields(models[0])
        self._fields: dict[str, Array] = {
            name: self._batch.bind(name) for name in (*self._state_fields, *fields)
        }
        self._ctrl = self._batch.bind("ctrl")
        self._derives = bool(fields)
        self._batch.reset(stage=mujoco.mjtStage.mjSTAGE_NONE.value)
        self._defaults = self._batch.state.copy()

    def field(self, name: str) -> Array:
        """A live field over all lanes."""
        return self._fields[name]

    def reset(self, lanes: Lanes, state: Mapping[str, Array]) -> None:
        """Defaults, then the given rows, then mj_forward if anything reads it, in the given lanes."""
        self._batch.state[lanes] = self._defaults[lanes]
        for name, rows in state.items():
            self._fields[name][lanes] = rows
        if self._derives:
            self._batch.forward(lanes)

    def step(self, ctrl: NDArray[Any], lanes: Lanes | None) -> None:
        """One environment step in the given lanes, or in all."""
        self._ctrl[...] = ctrl
        self._batch.step(lanes, self._frame_skip)

    def snapshot(self) -> dict[str, Array]:
        """Copies of the physics state of every lane."""
        return {name: np.array(self._fields[name]) for name in self._state_fields}

    def load(self, lanes: Lanes, state: Mapping[str, Array]) -> None:
        """Saved rows, then mj_forward; the warm start is written last, as the single environment does."""
        for name in self._state_fields:
            self._fields[name][lanes] = state[name]
        self._batch.forward(lanes)
        self._fields["qacc_warmstart"][lanes] = state["qacc_warmstart"]

    def close(self) -> None:
        """Lets the batch go."""
        self._fields.clear()
        del self._batch, self._ctrl
