"""Train agents through the protocols of a task group and write their submissions.

Importing this package loads neither a simulator nor torch; each name is imported on first use.

Example:
    >>> from gym_extensions.baselines import train
    >>> train("random", "hopper-gravity", "single", "smoke", runs=0, out="submissions/mine")  # doctest: +SKIP
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gym_extensions.baselines.adapters.sb3 import sb3
    from gym_extensions.baselines.agent import Agent, Card, Context, Factory, Observes, Resumable
    from gym_extensions.baselines.train_agent import train

__all__ = ["Agent", "Card", "Context", "Factory", "Observes", "Resumable", "sb3", "train"]

MODULES = {"sb3": "adapters.sb3", "train": "train_agent"}
"""The module of each public name; the others are in ``agent``."""
SB3_PACKAGES = ("torch", "stable_baselines3")
"""Packages of the extra ``sb3``."""
SB3_HINT = "Install it with: pip install 'gym-extensions[sb3]'"


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    try:
        module = importlib.import_module(f"{__name__}.{MODULES.get(name, 'agent')}")
    except ModuleNotFoundError as missing:
        package = (missing.name or "").partition(".")[0]
        if package not in SB3_PACKAGES:
            raise
        message = f"{name} needs {package}. {SB3_HINT}"
        raise ModuleNotFoundError(message, name=package) from missing
    return getattr(module, name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
