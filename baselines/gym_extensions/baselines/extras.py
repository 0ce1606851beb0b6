"""The packages of the optional extras, and the command that installs what is missing."""

from __future__ import annotations

EXTRAS = {"sb3": ("torch", "stable_baselines3"), "sbx": ("sbx", "jax", "flax", "optax")}
"""The packages that an extra adds, by its name in ``pyproject.toml``."""


def missing_extra(error: ModuleNotFoundError) -> tuple[str, str] | None:
    """The package that is missing and how to install it; None if it belongs to no extra."""
    package = (error.name or "").partition(".")[0]
    for extra, packages in EXTRAS.items():
        if package in packages:
            return package, f"Install it with: pip install 'gym-extensions[{extra}]'"
    return None
