"""The reference agents, one module each with a factory ``make``, and agents of the user by name."""

from __future__ import annotations

import importlib
import pkgutil
import sys
from pathlib import Path

from gym_extensions.baselines.agent import Factory
from gym_extensions.baselines.extras import missing_extra
from gym_extensions.errors import BenchError, did_you_mean


def names() -> list[str]:
    """The names of the reference agents: the modules' names, with dashes for underscores."""
    modules = (module for module in pkgutil.iter_modules(__path__) if not module.ispkg)
    return sorted(module.name.replace("_", "-") for module in modules)


def factory(agent: str | Factory) -> Factory:
    """The factory of an agent.

    Args:
        agent: the name of a reference agent (``"trpo"``), ``"module:attribute"``, or a factory.

    Raises:
        BenchError: an unknown agent, module or attribute, or the agent needs an extra that is not installed.
    """
    if not isinstance(agent, str):
        return agent
    module_name, _, attribute = agent.partition(":")
    if not attribute:
        if agent not in names():
            hint = did_you_mean(agent, names()) + " Name your own agent as module:factory."
            raise BenchError("unknown-agent", f"Unknown agent {agent!r}.", hint=hint.strip())
        module_name, attribute = f"{__name__}.{agent.replace('-', '_')}", "make"
    elif str(Path.cwd()) not in sys.path:
        sys.path.insert(0, str(Path.cwd()))
    try:
        module = importlib.import_module(module_name)
    except ModuleNotFoundError as missing:
        extra = missing_extra(missing)
        if extra is not None:
            raise BenchError("missing-extra", f"{agent} needs {extra[0]}.", hint=extra[1]) from missing
        if missing.name is None or not f"{module_name}.".startswith(f"{missing.name}."):
            raise
        hint = "Run the command in the folder of the module, or install the module."
        raise BenchError("unknown-agent", f"Module {module_name!r} was not found.", hint=hint) from missing
    if not callable(getattr(module, attribute, None)):
        choices = [name for name, value in vars(module).items() if callable(value)]
        raise BenchError(
            "unknown-agent",
            f"Module {module_name!r} has no callable {attribute!r}.",
            hint=did_you_mean(attribute, choices),
        )
    make: Factory = getattr(module, attribute)
    return make


def name_of(agent: str | Factory) -> str:
    """The name of an agent without a card: its factory's, or its module's if the factory is ``make``."""
    if isinstance(agent, str):
        module, _, attribute = agent.partition(":")
    else:
        module = getattr(agent, "__module__", type(agent).__module__)
        attribute = getattr(agent, "__name__", type(agent).__name__)
    return attribute if attribute not in ("", "make") else module.rpartition(".")[2]
