"""TRPO with fresh networks for every task: the twin of ``trpo`` without transfer and without memory."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from gym_extensions.baselines.agent import Array, Observes, VectorEnv
from gym_extensions.baselines.algorithms.trpo import Trpo


class Reset(Trpo):
    """The agent ``reset``. Policy, value function and moments start anew with every task after the first."""

    name, title = "reset", "TRPO + reset"
    description = "The reference agent with fresh networks for every task: no transfer and no memory."
    observes = Observes(boundaries=True)
    _used = False

    def learn(self, env: VectorEnv, steps: int) -> None:
        """Learns a task from scratch."""
        if self._used:
            self._initialize()
        self._used = True
        super().learn(env, steps)

    def _state(self) -> dict[str, Array]:
        return super()._state() | {"used": np.array(self._used)}

    def _restore(self, arrays: Mapping[str, Array]) -> None:
        super()._restore(arrays)
        self._used = bool(arrays["used"])


make = Reset
