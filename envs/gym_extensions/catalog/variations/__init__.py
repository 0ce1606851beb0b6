"""What can differ between a task and its base: one module per kind of variation.

``KINDS`` holds every variation class by its name. A new module in this folder is found by itself.
"""

from __future__ import annotations

import pkgutil
from dataclasses import is_dataclass
from importlib import import_module


def _kinds() -> dict[str, type]:
    modules = [import_module(f"{__name__}.{module.name}") for module in pkgutil.iter_modules(__path__)]
    return {
        name: kind
        for module in modules
        for name, kind in sorted(vars(module).items())
        if isinstance(kind, type) and kind.__module__ == module.__name__ and is_dataclass(kind)
    }


KINDS: dict[str, type] = _kinds()
"""The variation classes by name, for example ``Gravity``."""
