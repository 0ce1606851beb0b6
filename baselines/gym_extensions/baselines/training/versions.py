"""The versions on which the results of a job depend."""

from __future__ import annotations

from gym_extensions.installed import version

PACKAGES = ("gym_extensions", "gymnasium", "mujoco", "numpy")


def job_versions() -> dict[str, str]:
    """The version of each package."""
    return {name: version(name.replace("_", "-")) for name in PACKAGES}


def version_difference(stored: object) -> str:
    """What differs between stored and installed versions; empty if nothing does."""
    old = stored if isinstance(stored, dict) else {}
    return ", ".join(
        f"{name} {old.get(name, 'unknown')} (installed: {new})"
        for name, new in job_versions().items()
        if old.get(name) != new
    )
