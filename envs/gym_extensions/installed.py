"""The versions of installed packages."""

from __future__ import annotations

import functools
from importlib import metadata


@functools.cache
def version(package: str) -> str:
    """Returns the version of an installed package. It is read once per process: long metadata takes 4 ms."""
    return metadata.version(package)


def version_or_none(package: str) -> str | None:
    """Returns the version of a package; None if it is not installed."""
    try:
        return version(package)
    except metadata.PackageNotFoundError:
        return None
