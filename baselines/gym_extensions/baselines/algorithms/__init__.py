"""The reference agents by name, and agents of the user.

A module has one agent, with a factory ``make``, unless ``SHARED_MODULES`` says otherwise.
"""

from __future__ import annotations

import importlib
import pkgutil
import sys
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

from gym_extensions.errors import BenchError, did_you_mean

if TYPE_CHECKING:  # it loads Gymnasium, which the names of agents do not need
    from gym_extensions.baselines.agent import Factory

SHARED_MODULES = {
    "cloning": "continual:Cloning",
    "l2": "continual:L2",
    "l2-init": "continual:L2Init",
    "online-ewc": "continual:OnlineEwc",
    "random": "floors:Random",
    "reset": "trpo:Reset",
    "sac-fresh-buffer": "sac:make_fresh_buffer",
    "snapshots": "multi_head:Snapshots",
    "trpo-2017": "trpo:Trpo2017",
    "zero": "floors:Zero",
} | {
    f"{base}-{addition}": f"{base}:make_{addition.replace('-', '_')}"
    for base in ("ppo", "sac64")
    for addition in ("reset", "snapshots", "cloning", "online-ewc", "packnet")
}
"""The module and factory of agents that share a module with another one."""
WITHOUT_AGENT = ("additions", "continual", "floors")
"""Modules without a factory ``make``."""
NAME_A_FILE = "Name a file and its factory, such as path/to/agent.py:make."
EXTRAS = {
    "onnx": ("onnx", "onnxruntime"),
    "sb3": ("torch", "stable_baselines3"),
    "sbx": ("sbx", "jax", "flax", "optax"),
}
"""The packages that an extra of ``pyproject.toml`` adds."""


def missing_extra(module: str | None) -> tuple[str, str] | None:
    """The package of a module that is missing, and how to install it; None if it belongs to no extra."""
    package = (module or "").partition(".")[0]
    for extra, packages in EXTRAS.items():
        if package in packages:
            return package, f"Install it with: pip install 'gym-extensions[{extra}]'"
    return None


def names() -> list[str]:
    """The names of the modules, with dashes for underscores, and those of ``SHARED_MODULES``."""
    modules = (module.name for module in pkgutil.iter_modules(__path__) if module.name not in WITHOUT_AGENT)
    return sorted({*SHARED_MODULES, *(name.replace("_", "-") for name in modules)})


def place_of(agent: str) -> tuple[Path | None, str]:
    """The file, or folder of a package, of an agent that is named by its path, and the part after the colon.

    The path is None for the name of a reference agent and for ``module:attribute``. Raises ``BenchError`` if
    there is no such file.
    """
    place, colon, attribute = agent.rpartition(":")
    path = Path(place)
    if not colon or not (path.suffix == ".py" or path.is_dir() or "/" in place):
        return None, attribute
    path = path.parent if path.name == "__init__.py" else path
    if not (path / "__init__.py" if path.is_dir() else path).is_file():
        raise BenchError("unknown-agent", f"There is no file {path}.", agent, NAME_A_FILE)
    return path.resolve(), attribute


def factory(agent: str | Factory) -> Factory:
    """The factory of a reference agent's name (``"trpo"``), of ``"path/to/agent.py:attribute"``, of
    ``"module:attribute"``, or a factory itself.

    Raises:
        BenchError: an unknown agent, file, module or attribute, or the agent needs an extra that is not
            installed.
    """
    if not isinstance(agent, str):
        return agent
    path, attribute = place_of(agent)
    if ":" in agent:
        module_name = path.stem if path else agent.rpartition(":")[0]
        if not all(part.isidentifier() for part in module_name.split(".")):
            hint = "Rename the file: letters, digits and underscores." if path else NAME_A_FILE
            raise BenchError("unknown-agent", f"{module_name!r} is not the name of a module.", agent, hint)
        folder = str(path.parent if path else Path.cwd())
        if folder not in sys.path:
            sys.path.insert(0, folder)
    else:
        if agent not in names():
            hint = did_you_mean(agent, names()) + " Name your own agent as path/to/agent.py:factory."
            raise BenchError("unknown-agent", f"Unknown agent {agent!r}.", hint=hint.strip())
        home = SHARED_MODULES.get(agent, f"{agent.replace('-', '_')}:make")
        module_name, _, attribute = f"{__name__}.{home}".partition(":")
    try:
        module = importlib.import_module(module_name)
    except ModuleNotFoundError as missing:
        if extra := missing_extra(missing.name):
            raise BenchError("missing-extra", f"{agent} needs {extra[0]}.", hint=extra[1]) from missing
        if missing.name is None or not f"{module_name}.".startswith(f"{missing.name}."):
            raise
        hint = "Run the command in the folder of the module, or name its file: path/to/agent.py:factory."
        raise BenchError("unknown-agent", f"Module {module_name!r} was not found.", hint=hint) from missing
    if path and Path(module.__file__ or "").resolve() not in (path, path / "__init__.py"):
        message = f"Python has another module {module_name!r}: {module.__file__}."
        raise BenchError("unknown-agent", message, agent, "Rename the file.")
    return factory_in(module, attribute)


def factory_in(module: ModuleType, attribute: str) -> Factory:
    """The factory of this name in a module. Raises ``BenchError`` if it has no callable of this name."""
    make: Factory | None = getattr(module, attribute, None)
    if not callable(make):
        choices = [name for name, value in vars(module).items() if callable(value)]
        message = f"{module.__name__!r} has no callable {attribute!r}."
        raise BenchError("unknown-agent", message, hint=did_you_mean(attribute, choices))
    return make


def name_of(agent: str | Factory) -> str:
    """The name of an agent without a card: its factory's, or its module's if the factory is ``make``."""
    if isinstance(agent, str):
        path, attribute = place_of(agent)
        module = path.stem if path else agent.rpartition(":")[0]
    else:
        agent = getattr(agent, "func", agent)  # of functools.partial
        module = getattr(agent, "__module__", type(agent).__module__)
        attribute = getattr(agent, "__name__", type(agent).__name__)
    return attribute if attribute not in ("", "make") else module.rpartition(".")[2]
