"""Seeds, masks, indices and counts of vector environments."""

from __future__ import annotations

import operator
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gym_extensions.errors import BenchError

WHERE = "make_vec"
"""Where errors of vector environments are located."""


def check_count(name: str, count: Any, limit: int) -> int:
    """Returns a count as an int.

    Raises:
        BenchError: it is not a whole number from 1 to the limit.
    """
    try:
        number = operator.index(count)
    except TypeError:
        number = 0
    if isinstance(count, bool) or not 1 <= number <= limit:
        hint = f"Give a whole number from 1 to {limit}."
        raise BenchError("bad-count", f"{name} is {count!r}.", WHERE, hint)
    return number


def seed_of_each(seed: Any, num_envs: int) -> Sequence[int | None]:
    """Returns the seed of every environment.

    None continues with the environment's generator. An int gives environment i the seed ``seed + i``, as in
    Gymnasium. A list is returned as it is.

    Raises:
        BenchError: the list does not have one seed per environment, or a seed is not a whole number of at
            least 0.
    """
    if seed is None:
        return [None] * num_envs
    if isinstance(seed, int | np.integer) and not isinstance(seed, bool):
        seeds: list[Any] = [int(seed) + index for index in range(num_envs)]
    elif isinstance(seed, Sequence | np.ndarray) and not isinstance(seed, str):
        seeds = list(seed)
    else:
        raise BenchError("bad-seeds", f"seed is {seed!r}.", WHERE, "Give an int or one seed per environment.")
    if len(seeds) != num_envs:
        message = f"There are {len(seeds)} seeds for {num_envs} environments."
        raise BenchError("bad-seeds", message, WHERE, "Give one seed per environment, or one int.")
    for value in seeds:
        if value is not None and not (isinstance(value, int | np.integer) and value >= 0):
            raise BenchError("bad-seeds", f"A seed is {value!r}.", WHERE, "Give whole numbers of at least 0.")
    return [None if value is None else int(value) for value in seeds]


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


def check_indices(indices: Any, num_envs: int) -> NDArray[np.intp]:
    """Returns indices of environments as an array; None is all environments in order.

    Raises:
        BenchError: they are not different whole numbers below ``num_envs``.
    """
    if indices is None:
        return np.arange(num_envs)
    chosen = np.asarray(indices)
    whole = chosen.ndim == 1 and len(chosen) > 0 and chosen.dtype.kind in "iu"
    if not whole or chosen.min() < 0 or chosen.max() >= num_envs or len(np.unique(chosen)) < len(chosen):
        hint = f"Give different whole numbers from 0 to {num_envs - 1}."
        raise BenchError("bad-indices", f"indices is {indices!r}.", WHERE, hint)
    return chosen.astype(np.intp)
