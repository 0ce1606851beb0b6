"""A sample of the observations of a task, taken while the agent learns it."""

from __future__ import annotations

import numpy as np

from gym_extensions.baselines.agent import Array


class StateSample:
    """Every k-th observation of the last half of a task, at most ``size`` of them.

    The last half is many episodes long, also where all environments reset together, and its states are near
    those of the final policy. No random number is drawn. k is odd, so that it is not a multiple of an even
    number of environments.

    Args:
        size: observations to sample.
        steps: transitions of the task.
    """

    def __init__(self, size: int, steps: int) -> None:
        self._size, self._start, self._seen = size, steps // 2, 0
        stride = max(1, (steps - self._start) // max(size, 1))
        self._stride = stride - 1 if stride > 1 and stride % 2 == 0 else stride
        self._parts: list[Array] = []

    def add(self, observations: Array) -> None:
        """Samples from the next observations (n, o) of the task."""
        rows = np.arange(self._seen, self._seen + len(observations)) - self._start
        self._seen += len(observations)
        chosen = (rows >= 0) & (rows % self._stride == 0) & (rows < self._size * self._stride)
        self._parts.append(observations[chosen])

    @property
    def observations(self) -> Array:
        """The sample (n, o)."""
        return np.concatenate(self._parts)
