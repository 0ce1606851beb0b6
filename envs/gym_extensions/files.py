"""Files that are written completely or not at all, and compiled code that is cached in files."""

import functools
import hashlib
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

F = TypeVar("F", bound=Callable[..., Any])


def write_bytes(path: Path, content: bytes) -> None:
    """Writes to a temporary file of its own in the same folder, then renames it.

    So several processes may write the file at once.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(f".{path.name}.{os.urandom(8).hex()}.partial")
    try:
        partial.write_bytes(content)
        partial.replace(path)
    except BaseException:  # a full disk, Ctrl-C
        partial.unlink(missing_ok=True)
        raise


def remove(path: Path) -> None:
    """Deletes a file, or a folder with all that is in it; nothing if there is none."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> None:
    """Writes a text file, UTF-8 with ``\\n``, whole or not at all."""
    write_bytes(path, text.encode())


@functools.cache
def sources_digest(folder: Path) -> str:
    """Returns the sha256 of the modules in a folder, on which the compiled code of each of them depends."""
    return hashlib.sha256(b"".join(path.read_bytes() for path in sorted(folder.glob("*.py")))).hexdigest()


def compiled(function: F) -> F:
    """Compiles the function at its first call, in strict IEEE arithmetic, and caches the code on disk.

    The cache is beside the module, or in the user's cache folder. If neither can be written, the function is
    compiled once per process.
    """
    import numba  # takes half a second

    dispatcher: Any = numba.njit(error_model="numpy")(function)  # 1 / 0 is inf, so that loops use vectors
    try:
        dispatcher.enable_caching()
    except RuntimeError:  # no folder for the cache can be written
        return cast(F, dispatcher)
    # Numba reuses cached code if the time and size of the function's own file are unchanged. Wheels give
    # every file the same time, and a constant or a callee may be in another file: numba would silently run
    # outdated code.
    folder = Path(function.__code__.co_filename).parent
    dispatcher._cache._cache_file._source_stamp = sources_digest(folder)
    return cast(F, dispatcher)
