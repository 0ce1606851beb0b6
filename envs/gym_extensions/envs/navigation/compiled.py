"""The decorator of every compiled function."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba

F = TypeVar("F", bound=Callable[..., Any])


def compiled(function: F) -> F:
    """The function compiled by numba at its first call, in strict IEEE arithmetic, and kept on disk.

    The code is kept beside the module, else in the user's cache folder; where neither can be written it is
    compiled once a process.
    """
    try:
        return cast(F, numba.njit(cache=True, fastmath=False)(function))
    except RuntimeError:  # numba found no folder in which to keep it
        return cast(F, numba.njit(fastmath=False)(function))
