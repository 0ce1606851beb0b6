"""The decorator of functions that numba compiles."""

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
    """Returns the sha256 of this package's modules, on which compiled code depends."""
    modules = sorted((path for path in files(__package__).iterdir() if path.name.endswith(".py")), key=str)
    return hashlib.sha256(b"".join(path.read_bytes() for path in modules)).hexdigest()


def compiled(function: F) -> F:
    """Compiles the function at its first call, in strict IEEE arithmetic, and caches the code on disk.

    The cache is beside the module, or in the user's cache folder. If neither can be written, the function is
    compiled once per process.
    """
    dispatcher = numba.njit(function)
    try:
        dispatcher.enable_caching()
    except RuntimeError:  # no folder for the cache can be written
        return cast(F, dispatcher)
    # Numba reuses cached code if the time and size of the function's own file are unchanged. Wheels give
    # every file the same time, and a constant or a callee may be in another file: numba would silently run
    # outdated code.
    dispatcher._cache._cache_file._source_stamp = sources_digest()
    return cast(F, dispatcher)
