"""Physics of many environments: in mujoco.batch, or one MjData each for rules that read contact forces."""

import ctypes
import os
import weakref
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import mujoco
import numpy as np
from mujoco.batch import Batch
from numpy.typing import NDArray

from gym_extensions.envs.interfaces import Array, Indices, Physics, Starts

_THREADED: "weakref.WeakSet[Physics]" = weakref.WeakSet()
"""The simulations that are open and have threads of their own."""


def _lose_threads() -> None:
    """Marks simulations in a forked process, where their threads do not exist.

    The engine would wait for its threads for ever when it is freed, so it is never freed.
    """
    for physics in _THREADED:
        physics.lost_threads = True
        if isinstance(physics, BatchPhysics):
            ctypes.pythonapi.Py_IncRef(ctypes.py_object(physics.batch))


if hasattr(os, "register_at_fork"):  # not on Windows, which does not fork
    os.register_at_fork(after_in_child=_lose_threads)


def _coordinates(model: mujoco.MjModel) -> tuple[str, ...]:
    return ("qpos", "qvel", *(("mocap_pos", "mocap_quat") if model.nmocap else ()))


class BatchPhysics(Physics):
    """Simulations in mujoco.batch. Derived fields are bit for bit those that mj_step leaves."""

    def __init__(
        self, models: Sequence[mujoco.MjModel], frame_skip: int, num_threads: int, fields: Sequence[str]
    ) -> None:
        self.batch = Batch(models[0], len(models), num_threads)
        if any(model is not models[0] for model in models):
            self.batch.set_models(models)
        if num_threads > 1:
            _THREADED.add(self)
        self._frame_skip = frame_skip
        self._state_fields = (*_coordinates(models[0]), "time")
        self._is_derived = bool(fields)
        self._fields = {name: self.batch.bind(name) for name in (*self._state_fields, *fields)}
        self._ctrl = self.batch.bind("ctrl")
        self.batch.reset(stage=mujoco.mjtStage.mjSTAGE_NONE.value)
        self._defaults = self.batch.state.copy()

    def reset(self, indices: Indices, starts: Starts) -> None:
        """Writes defaults, then the given rows, then runs mj_forward if derived fields are read."""
        self.batch.state[indices] = self._defaults[indices]
        for name, rows in starts.items():
            self._fields[name][indices] = rows
        if self._is_derived:
            self.batch.forward(indices)

    def step(self, ctrl: NDArray[Any], indices: Indices | None) -> None:
        self._ctrl[...] = ctrl
        self.batch.step(indices, self._frame_skip)

    def states(self) -> dict[str, Array]:
        return {name: np.array(self._fields[name]) for name in self._state_fields}

    def close(self) -> None:
        _THREADED.discard(self)
        self._fields.clear()
        del self.batch, self._ctrl


class PooledPhysics(Physics):
    """One MjData per environment; mj_step and mj_rnePostConstraint release the interpreter's lock.

    mujoco.batch runs mj_rnePostConstraint only for sensors, which Humanoid's Runge–Kutta integrator
    evaluates at a different stage than Gymnasium does (ADR 25).
    """

    def __init__(
        self, models: Sequence[mujoco.MjModel], frame_skip: int, num_threads: int, fields: Sequence[str]
    ) -> None:
        self._models = list(models)
        self._data = [mujoco.MjData(model) for model in models]
        self._frame_skip = frame_skip
        self._threads = min(num_threads, len(self._data))
        self._executor = ThreadPoolExecutor(max(self._threads - 1, 1))  # starts threads when they are needed
        if self._threads > 1:
            _THREADED.add(self)
        coordinates = _coordinates(models[0])
        self._state_fields = (*coordinates, "time")
        shapes = {name: getattr(self._data[0], name).shape for name in (*coordinates, *fields)}
        self._fields = {name: np.zeros((len(models), *shape)) for name, shape in shapes.items()}
        self._copies = [
            [(rows[index], getattr(data, name)) for name, rows in self._fields.items()]
            for index, data in enumerate(self._data)
        ]

    def reset(self, indices: Indices, starts: Starts) -> None:
        """Writes defaults, then the given rows, and runs mj_forward."""
        for row, index in enumerate(indices):
            model, data = self._models[index], self._data[index]
            mujoco.mj_resetData(model, data)
            for name, rows in starts.items():
                getattr(data, name)[...] = rows[row]
            mujoco.mj_forward(model, data)
            self._gather(index)

    def step(self, ctrl: NDArray[Any], indices: Indices | None) -> None:
        waiting = iter(range(len(self._data)) if indices is None else indices.tolist())

        def advance() -> None:
            for index in waiting:  # every thread takes the next one, so uneven work balances out
                model, data = self._models[index], self._data[index]
                data.ctrl[:] = ctrl[index]
                mujoco.mj_step(model, data, self._frame_skip)
                mujoco.mj_rnePostConstraint(model, data)
                self._gather(index)

        others = [self._executor.submit(advance) for _ in range(self._threads - 1)]
        advance()
        for other in others:
            other.result()

    def _gather(self, index: int) -> None:
        for row, source in self._copies[index]:
            row[...] = source

    def states(self) -> dict[str, Array]:
        return {name: np.array([getattr(data, name) for data in self._data]) for name in self._state_fields}

    def close(self) -> None:
        _THREADED.discard(self)
        self._executor.shutdown()
