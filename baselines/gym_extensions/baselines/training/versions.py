"""The versions on which the results of a job depend."""

from __future__ import annotations

from collections.abc import Iterable

from gym_extensions.installed import version

PACKAGES = ("gym_extensions", "gymnasium", "mujoco", "numpy")
BETWEEN = ", "
"""What separates several values in one text."""
UNKNOWN = "unknown"
"""BLAS kernels that were not recorded."""


def joined(texts: Iterable[str]) -> str:
    """The distinct values of texts that have one value or several, in order."""
    return BETWEEN.join(dict.fromkeys(value for text in texts if text for value in text.split(BETWEEN)))


def job_versions(packages: Iterable[str] = ()) -> dict[str, str]:
    """The versions of the packages that every job uses, and of those that its agent uses besides them."""
    return {name: version(name.replace("_", "-")) for name in (*PACKAGES, *packages)}


def version_difference(stored: object, packages: Iterable[str] = ()) -> str:
    """What differs between stored and installed versions; empty if nothing does."""
    old = stored if isinstance(stored, dict) else {}
    return ", ".join(
        f"{name} {old.get(name, 'unknown')} (installed: {new})"
        for name, new in job_versions(packages).items()
        if old.get(name) != new
    )
