"""Motor noise as pure functions over arrays."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

KEPT_EPISODES = 256
"""Episodes whose noise is kept, for that many lanes in flight."""


@functools.lru_cache(maxsize=KEPT_EPISODES)
def motor_noise(seed: int, steps: int, motors: int) -> Array:
    """An episode's standard normal noise, (steps, motors), from the seed alone; read-only."""
    noise = np.random.Generator(np.random.PCG64(seed)).standard_normal((steps, motors))
    noise.flags.writeable = False
    return noise


def applied(commands: NDArray[Any], noise: Array, ranges: Array, scale: float) -> Array:
    """What the motors get: commands (…, motors) plus noise of ``scale`` × their range, clipped to it.

    ``ranges`` is (motors, 2), low and high; ``noise`` is standard normal, shaped as the commands.
    """
    low, high = ranges[:, 0], ranges[:, 1]
    return np.clip(commands + scale * (high - low) * noise, low, high)
