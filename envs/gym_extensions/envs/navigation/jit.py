"""The decorator of every compiled function."""

from __future__ import annotations

import functools
import hashlib
from collections.abc import Callable
from importlib.resources import files
from typing import Any, TypeVar, cast

import numba

F = TypeVar("F", bound=Callable[..., Any])


@functools.cache
def sources_digest() -> str:
    """The sha256 of this package's modules: what compiled code depends on."""
    modules = sorted((path for path in files(__package__).iterdir() if path.name.endswith(".py")), key=str)
    return hashlib.sha256(b"".join(path.read_bytes() for path in modules)).hexdigest()


def compiled(function: F) -> F:
    """The function compiled by numba at its first call, in strict IEEE arithmetic, and kept on disk.

    The code is kept beside the module, else in the user's cache folder; where neither can be written it is
    compiled once a process.
    """
    dispatcher = numba.njit(function)
    try:
        dispatcher.enable_caching()
    except RuntimeError:  # numba found no folder in which to keep it
        return cast(F, dispatcher)
    # Numba takes kept code for fresh if its own file's time and size are unchanged. Wheels give every file
    # the same time, and a constant or a callee may stand in another file: that would be yesterday's physics,
    # silently.
    dispatcher._cache._cache_file._source_stamp = sources_digest()
    return cast(F, dispatcher)
