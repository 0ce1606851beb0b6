"""Simulations of one model layout, stepped by mujoco.batch."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np
from mujoco.batch import Batch
from numpy.typing import NDArray

from gym_extensions.envs.protocols import Array, Indices, States
from gym_extensions.envs.state import INTEGRATED, MOCAP


def state_fields(model: mujoco.MjModel) -> tuple[str, ...]:
    """Names of the physics part of a saved state of this model."""
    return (*INTEGRATED, "time", *(MOCAP if model.nmocap else ()))


class BatchPhysics:
    """Simulations in mujoco.batch. Derived fields are bit for bit those that mj_step leaves."""

    def __init__(
        self, models: Sequence[mujoco.MjModel], frame_skip: int, num_threads: int, fields: Sequence[str]
    ) -> None:
        self._batch = Batch(models[0], len(models), num_threads)
        if any(model is not models[0] for model in models):
            self._batch.set_models(models)
        self._frame_skip = frame_skip
        self._state_fields = state_fields(models[0])
        self._fields: dict[str, Array] = {name: self._batch.bind(name) for name in self._state_fields}
        # The engine's outputs are read-only. A copy of them can be written when a copy of all this is made.
        self._outputs = [(self._batch.bind(name), np.zeros_like(self._batch.bind(name))) for name in fields]
        self._fields |= {name: copy for name, (_, copy) in zip(fields, self._outputs, strict=True)}
        self._ctrl = self._batch.bind("ctrl")
        self._batch.reset(stage=mujoco.mjtStage.mjSTAGE_NONE.value)
        self._defaults = self._batch.state.copy()

    def field(self, name: str) -> Array:
        """Returns a live field, ``(num_envs, …)``."""
        return self._fields[name]

    def reset(self, indices: Indices, state: States) -> None:
        """Writes defaults, then the given rows, then runs mj_forward if derived fields are read."""
        self._batch.state[indices] = self._defaults[indices]
        for name, rows in state.items():
            self._fields[name][indices] = rows
        if self._outputs:
            self._batch.forward(indices)
            self._refresh(indices)

    def step(self, ctrl: NDArray[Any], indices: Indices | None) -> None:
        """Runs one environment step in some environments, or in all."""
        self._ctrl[...] = ctrl
        self._batch.step(indices, self._frame_skip)
        if self._outputs:
            self._refresh(slice(None) if indices is None else indices)

    def _refresh(self, rows: Indices | slice) -> None:
        for output, copy in self._outputs:
            copy[rows] = output[rows]

    def snapshot(self) -> dict[str, Array]:
        """Returns copies of the physics state of every environment."""
        return {name: np.array(self._fields[name]) for name in self._state_fields}

    def load(self, indices: Indices, state: States) -> None:
        """Writes saved rows, runs mj_forward, then writes the warm start, as the single environment does."""
        for name in self._state_fields:
            self._fields[name][indices] = state[name]
        self._batch.forward(indices)
        self._fields["qacc_warmstart"][indices] = state["qacc_warmstart"]
        self._refresh(indices)

    def dump(self) -> dict[str, Array]:
        """Returns copies of the engine's state and of the derived fields."""
        names = self._fields.keys() - set(self._state_fields)
        return {name: self._fields[name].copy() for name in sorted(names)} | {"": self._batch.state.copy()}

    def undump(self, dumped: dict[str, Array]) -> None:
        """Writes what ``dump`` returned."""
        for name, rows in dumped.items():
            (self._fields[name] if name else self._batch.state)[...] = rows

    def close(self) -> None:
        """Frees the batch."""
        self._fields.clear()
        self._outputs.clear()
        del self._batch, self._ctrl
