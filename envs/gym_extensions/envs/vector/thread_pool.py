"""Lanes with an MjData each, stepped by a few Python threads: for tasks that read mj_rnePostConstraint."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from gym_extensions.envs.state import MOCAP
from gym_extensions.envs.vector.physics import Array, Lanes, state_fields


class PooledPhysics:
    """Simulations in an MjData each; mj_step and mj_rnePostConstraint release the interpreter's lock.

    mujoco.batch cannot serve here: mj_rnePostConstraint runs there only for sensors, which Humanoid's
    Runge–Kutta integrator evaluates at another of its four stages than Gymnasium does (ADR 0026).
    """

    def __init__(
        self, models: Sequence[mujoco.MjModel], frame_skip: int, num_threads: int, fields: Sequence[str]
    ) -> None:
        self._models = list(models)
        self._data = [mujoco.MjData(model) for model in models]
        self._frame_skip = frame_skip
        self._threads = min(num_threads, len(self._data))
        self._executor = ThreadPoolExecutor(self._threads - 1) if self._threads > 1 else None
        self._state_fields = state_fields(models[0])
        gathered = dict.fromkeys(("qpos", "qvel", *(MOCAP if models[0].nmocap else ()), *fields))
        self._fields: dict[str, Array] = {
            name: np.zeros((len(models), *np.shape(getattr(self._data[0], name)))) for name in gathered
        }
        self._controls = [data.ctrl for data in self._data]
        self._copies = [
            [(rows[lane], getattr(data, name)) for name, rows in self._fields.items()]
            for lane, data in enumerate(self._data)
        ]

    def field(self, name: str) -> Array:
        """A gathered field over all lanes."""
        return self._fields[name]

    def reset(self, lanes: Lanes, state: Mapping[str, Array]) -> None:
        """Defaults, then the given rows, then mj_forward, in the given lanes."""
        for row, lane in enumerate(lanes):
            model, data = self._models[lane], self._data[lane]
            mujoco.mj_resetData(model, data)
            for name, rows in state.items():
                getattr(data, name)[...] = rows[row]
            mujoco.mj_forward(model, data)
            self._gather(lane)

    def step(self, ctrl: NDArray[Any], lanes: Lanes | None) -> None:
        """One environment step in the given lanes, or in all."""
        models, datas, controls, frame_skip = self._models, self._data, self._controls, self._frame_skip

        def advance(lane: int) -> None:
            model, data = models[lane], datas[lane]
            controls[lane][:] = ctrl[lane]
            mujoco.mj_step(model, data, frame_skip)
            mujoco.mj_rnePostConstraint(model, data)
            self._gather(lane)

        self._spread(advance, range(len(datas)) if lanes is None else lanes.tolist())

    def _gather(self, lane: int) -> None:
        for row, source in self._copies[lane]:
            row[...] = source

    def _spread(self, work: Callable[[int], None], lanes: Iterable[int]) -> None:
        """Runs the work of every lane; threads take the next waiting lane, so uneven lanes balance out."""
        waiting = deque(lanes)

        def drain() -> None:
            while True:
                try:
                    lane = waiting.popleft()
                except IndexError:
                    return
                work(lane)

        if self._executor is None:
            drain()
            return
        others = [self._executor.submit(drain) for _ in range(self._threads - 1)]
        drain()
        for other in others:
            other.result()

    def snapshot(self) -> dict[str, Array]:
        """Copies of the physics state of every lane."""
        return {
            name: np.array([getattr(data, name) for data in self._data], dtype=np.float64)
            for name in self._state_fields
        }

    def load(self, lanes: Lanes, state: Mapping[str, Array]) -> None:
        """Saved rows, then mj_forward; the warm start is written last, as the single environment does."""
        for row, lane in enumerate(lanes):
            data = self._data[lane]
            data.time = float(state["time"][row])
            for name in self._state_fields:
                if name != "time":
                    getattr(data, name)[...] = state[name][row]
            mujoco.mj_forward(self._models[lane], data)
            data.qacc_warmstart[...] = state["qacc_warmstart"][row]
            self._gather(lane)

    def close(self) -> None:
        """Ends the threads."""
        if self._executor is not None:
            self._executor.shutdown()
