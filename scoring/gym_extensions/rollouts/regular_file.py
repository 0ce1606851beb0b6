"""Reads regular files, which an attacker may exchange for links or devices after the folder was listed."""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path

SAFE = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_CLOEXEC", 0)
"""Do not follow a link, do not wait for the writer of a FIFO, do not pass the file to other programs."""
READ = os.O_RDONLY | getattr(os, "O_BINARY", 0) | SAFE
FOLDER = READ | getattr(os, "O_DIRECTORY", 0)
HAS_FOLDERS = os.open in os.supports_dir_fd


def read_regular(root: Path, path: str, max_bytes: int) -> bytes:
    """The bytes of a regular file.

    Every part of the path is opened relative to the folder before it, so that no part may be a link. (Windows
    opens the whole path.)

    Args:
        root: the folder, which may be a link.
        path: the path in it, with ``/``.
        max_bytes: the largest size.

    Raises:
        OSError: it cannot be read, is a link or not a regular file, or is larger.
    """
    descriptor = _opened(root, path)
    with os.fdopen(descriptor, "rb") as file:
        status = os.fstat(descriptor)
        if not stat.S_ISREG(status.st_mode):
            raise OSError(errno.EINVAL, "It is not a regular file")
        data = file.read(max_bytes + 1) if status.st_size <= max_bytes else None
    if data is None or len(data) > max_bytes:
        raise OSError(errno.EFBIG, f"It has more than {max_bytes} bytes")
    return data


def _opened(root: Path, path: str) -> int:
    if not HAS_FOLDERS:
        return os.open(root / path, READ)
    *folders, name = path.split("/")
    folder = os.open(root, FOLDER & ~getattr(os, "O_NOFOLLOW", 0))
    try:
        for part in folders:
            inner = os.open(part, FOLDER, dir_fd=folder)
            os.close(folder)
            folder = inner
        return os.open(name, READ, dir_fd=folder)
    finally:
        os.close(folder)
