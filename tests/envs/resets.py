"""The states that many resets of a task give, and a test of their distribution."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from gym_extensions.catalog.tasks import task
from gym_extensions.envs.mujoco.env import TaskEnv


def assert_uniform(values: NDArray[np.float64], low: float, high: float) -> None:
    """Fails if the values, shape (n,), are not uniform between the bounds (Kolmogorov–Smirnov test)."""
    assert values.min() >= low
    assert values.max() <= high
    assert stats.kstest(values, "uniform", args=(low, high - low)).pvalue > 1e-3


def states_after_reset(
    name: str, read: Callable[[TaskEnv], NDArray[np.float64]], count: int = 2000
) -> NDArray[np.float64]:
    """What ``read`` returns after each of ``count`` resets, one row per reset."""
    env = TaskEnv(task(name))
    env.reset(seed=0)
    rows = []
    for _ in range(count):
        env.reset()
        rows.append(read(env))
    return np.array(rows)
