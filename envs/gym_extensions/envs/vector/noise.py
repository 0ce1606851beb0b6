"""Reset noise for several lanes, each from its own generator."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gym_extensions.envs.vector.physics import Array


def uniform_rows(generators: Sequence[np.random.Generator], noise: float, size: int) -> Array:
    """A row of ``size`` numbers in [−noise, noise) from each generator."""
    return np.array([own.uniform(-noise, noise, size) for own in generators])


def uniform_state(
    generators: Sequence[np.random.Generator], noise: float, nq: int, nv: int
) -> tuple[Array, Array]:
    """Rows of nq, then of nv numbers; one call gives the numbers that two in a row would."""
    rows = uniform_rows(generators, noise, nq + nv)
    return rows[:, :nq], rows[:, nq:]
