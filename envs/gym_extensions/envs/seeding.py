"""Seeds and masks of a vector environment's reset."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gym_extensions.errors import BenchError

WHERE = "make_vec"
"""Where errors of vector environments are located."""


def spawn_seeds(seed: int, num_envs: int) -> list[int]:
    """Spawns one seed per environment from one seed. Neighboring seeds share none of them."""
    return [int(child.generate_state(1)[0]) for child in np.random.SeedSequence(seed).spawn(num_envs)]


def seed_of_each(seed: int | Sequence[int | None] | None, num_envs: int) -> Sequence[int | None]:
    """Returns the seed of every environment.

    None continues with the environment's generator.

    An int is spawned into one seed per environment; a list is returned as it is.

    Raises:
        BenchError: the list does not have one seed per environment.
    """
    if seed is None:
        return [None] * num_envs
    if isinstance(seed, int | np.integer):
        return spawn_seeds(int(seed), num_envs)
    if len(seed) != num_envs:
        message = f"There are {len(seed)} seeds for {num_envs} environments."
        raise BenchError("bad-seeds", message, WHERE, "Give one seed per environment, or one int.")
    return [None if value is None else int(value) for value in seed]


def reset_mask(options: dict[str, Any] | None, num_envs: int) -> NDArray[np.bool_]:
    """Returns which environments to reset, ``(num_envs,)``, from the option ``reset_mask``, or all.

    Raises:
        BenchError: the mask does not have one boolean per environment, or is all false.
    """
    mask = (options or {}).get("reset_mask")
    if mask is None:
        return np.ones(num_envs, np.bool_)
    chosen = np.asarray(mask)
    if chosen.shape != (num_envs,) or chosen.dtype != np.bool_ or not chosen.any():
        hint = f"Give {num_envs} booleans, at least one of them true."
        raise BenchError("bad-reset-mask", f"reset_mask is {mask!r}.", WHERE, hint)
    return chosen
