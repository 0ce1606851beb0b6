"""The reference agents by name, a module each with a factory ``make``; and agents of one's own."""

from __future__ import annotations

import importlib
import pkgutil
import sys
from pathlib import Path

from gym_extensions.baselines.agent import Factory
from gym_extensions.errors import BenchError, did_you_mean


def names() -> list[str]:
    """The names of the reference agents: the modules' names, with dashes for underscores."""
    return sorted(module.name.replace("_", "-") for module in pkgutil.iter_modules(__path__))


def factory(name: str) -> Factory:
    """The factory of a reference agent (``trpo``), or of one's own (``module:factory``).

    Raises:
        BenchError: there is no such agent, module or attribute.
    """
    module_name, _, attribute = name.partition(":")
    if not attribute:
        if name not in names():
            hint = did_you_mean(name, names()) + " An agent of your own is named as module:factory."
            raise BenchError("unknown-agent", f"There is no agent {name!r}.", hint=hint.strip())
        module_name, attribute = f"{__name__}.{name.replace('-', '_')}", "make"
    elif str(Path.cwd()) not in sys.path:
        sys.path.insert(0, str(Path.cwd()))
    try:
        module = importlib.import_module(module_name)
    except ModuleNotFoundError as missing:
        if missing.name is None or not module_name.startswith(missing.name):
            raise
        hint = "Run from the folder that holds it, or install it."
        raise BenchError("unknown-agent", f"There is no module {module_name!r}.", hint=hint) from missing
    if not callable(getattr(module, attribute, None)):
        choices = [known for known, value in vars(module).items() if callable(value)]
        raise BenchError(
            "unknown-agent",
            f"Module {module_name!r} has nothing callable named {attribute!r}.",
            hint=did_you_mean(attribute, choices),
        )
    made: Factory = getattr(module, attribute)
    return made
