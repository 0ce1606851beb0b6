"""Computes ``is_success`` of single environments and of arrays of environments, and its vector infos."""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.bodies.success import Arrival, Distance, Height, Success

ROOT_HEIGHT = 2
"""Index of a free root's height in ``qpos``."""

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]


class DistanceTest:
    """Whether two bodies are close in the x–y plane, from ``xpos`` (…, nbody, 3)."""

    field = "xpos"

    def __init__(self, rule: Distance, model: mujoco.MjModel) -> None:
        self._first, self._second = (model.body(name).id for name in rule.bodies)
        self._limit = rule.limit * rule.limit

    def __call__(self, values: Array) -> Flags:
        """Returns (…,) booleans."""
        gap = values[..., self._first, :2] - values[..., self._second, :2]
        x, y = gap[..., 0], gap[..., 1]
        close: Flags = x * x + y * y <= self._limit
        return close


class HeightTest:
    """Whether a free root's height is inside an open interval, from ``qpos`` (…, nq)."""

    field = "qpos"

    def __init__(self, rule: Height) -> None:
        self._low, self._high = rule.low, rule.high

    def __call__(self, values: Array) -> Flags:
        """Returns (…,) booleans."""
        height = values[..., ROOT_HEIGHT]
        upright: Flags = (height > self._low) & (height < self._high)
        return upright


def success_test(rule: Success | None, model: mujoco.MjModel) -> DistanceTest | HeightTest | None:
    """Returns the test of a MuJoCo body's success, or None if the body defines none.

    ``field`` names the field of ``MjData`` that it is called with.

    Raises:
        ValueError: success is the arrival at a goal, which only navigation has.
    """
    match rule:
        case None:
            return None
        case Distance():
            return DistanceTest(rule, model)
        case Height():
            return HeightTest(rule)
        case Arrival():
            raise ValueError("The bodies with a MuJoCo model have no arrival. Define a distance or a height.")
