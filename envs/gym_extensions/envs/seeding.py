"""What a vector environment's reset asks for: one seed a lane, and which lanes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gym_extensions.errors import BenchError

WHERE = "make_batch"
"""The place that errors of the vector environment name."""


def lane_seeds(seed: int, num_envs: int) -> list[int]:
    """One seed a lane, spawned from one seed, so that neighbouring seeds share no lane."""
    return [int(child.generate_state(1)[0]) for child in np.random.SeedSequence(seed).spawn(num_envs)]


def seed_of_each(seed: int | Sequence[int | None] | None, num_envs: int) -> Sequence[int | None]:
    """Every lane's seed: spawned from an int, a list as it is, None where a lane goes on with its generator.

    Raises:
        BenchError: a list of another length.
    """
    if seed is None:
        return [None] * num_envs
    if isinstance(seed, int | np.integer):
        return lane_seeds(int(seed), num_envs)
    if len(seed) != num_envs:
        message = f"There are {len(seed)} seeds for {num_envs} lanes."
        raise BenchError("bad-seeds", message, WHERE, "Give one seed a lane, or one int for all.")
    return [None if own is None else int(own) for own in seed]


def reset_mask(options: dict[str, Any] | None, num_envs: int) -> NDArray[np.bool_]:
    """Which lanes a reset is for: the option ``reset_mask``, or all.

    Raises:
        BenchError: the mask is not one boolean a lane, or all false.
    """
    mask = (options or {}).get("reset_mask")
    if mask is None:
        return np.ones(num_envs, np.bool_)
    chosen = np.asarray(mask)
    if chosen.shape != (num_envs,) or chosen.dtype != np.bool_ or not chosen.any():
        hint = f"Give {num_envs} booleans, at least one of them true."
        raise BenchError("bad-reset-mask", f"reset_mask is {mask!r}.", WHERE, hint)
    return chosen
