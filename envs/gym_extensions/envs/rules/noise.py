"""Reset noise for several environments, each from its own generator."""

from __future__ import annotations

import numpy as np

from gym_extensions.envs.protocols import Array, Generators


def uniform_rows(generators: Generators, noise: float, size: int) -> Array:
    """Draws ``size`` numbers in [−noise, noise) from each generator, (generators, size)."""
    return np.array([generator.uniform(-noise, noise, size) for generator in generators])


def uniform_state(generators: Generators, noise: float, nq: int, nv: int) -> tuple[Array, Array]:
    """Draws rows of nq, then of nv numbers. One call gives the numbers of two calls in a row."""
    rows = uniform_rows(generators, noise, nq + nv)
    return rows[:, :nq], rows[:, nq:]
