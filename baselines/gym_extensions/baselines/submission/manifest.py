"""submission.toml: what the recorder writes, and what it leaves as its author wrote it."""

from __future__ import annotations

import platform
import tomllib
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

import tomli_w

from gym_extensions.atomic import write_text
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.manifest import FORMAT, SECTIONS

FIXED = ("protocol", "hyperparameters")
"""Sections that every run of a submission shares; a run with others is refused."""
FIXED_VERSIONS = ("gymnasium", "mujoco")
"""Packages that make the physics: runs of different versions are not mixed."""
SEPARATE = "A submission is one algorithm at one budget with one set of settings; choose another --out."


def versions() -> dict[str, str]:
    """The packages and the platform that this process runs on."""
    packages = {
        "gym_extensions": "gym-extensions",
        "gymnasium": "gymnasium",
        "mujoco": "mujoco",
        "numpy": "numpy",
    }
    found = {key: version(package) for key, package in packages.items()}
    return found | {
        "python": platform.python_version(),
        "platform": f"{platform.system()}-{platform.machine()}",
    }


def read(path: Path) -> dict[str, Any]:
    """The manifest's tables; empty where there is none; raises ``BenchError`` where it is not TOML."""
    if not path.exists():
        return {}
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as broken:
        hint = "Correct that place, or choose another --out."
        raise BenchError("bad-manifest", f"This is no TOML: {broken}.", str(path), hint) from broken


def written(card: Mapping[str, Any], budget: str, lanes: int | None) -> dict[str, Any]:
    """The sections that follow from the run: ``protocol``, ``hyperparameters``, ``versions``.

    Settings are as TOML gives them back (a tuple is a list), so that a later run finds its own.
    """
    settings = dict(card["hyperparameters"]) | ({} if lanes is None else {"lanes": lanes})
    settings = tomllib.loads(tomli_w.dumps(settings))
    return {
        "protocol": {"budget": budget, "algorithm": card["algorithm"], "evaluation": card["evaluation"]},
        "hyperparameters": settings,
        "versions": versions(),
    }


def refuse_mixing(path: Path, existing: Mapping[str, Any], new: Mapping[str, Any]) -> None:
    """Raises ``BenchError`` if the manifest that is there belongs to another algorithm, budget or setting."""
    for section in FIXED:
        old = existing.get(section)
        if old is None or old == new[section]:
            continue
        for key in sorted(old.keys() | new[section].keys()):
            was, now = old.get(key), new[section].get(key)
            if was != now:
                message = f"{section}.{key} is {was!r} in this submission and {now!r} in the run."
                raise BenchError("mixed-submission", message, str(path), SEPARATE)
    for key in FIXED_VERSIONS:
        was, now = existing.get("versions", {}).get(key), new["versions"][key]
        if was not in (None, now):
            message = f"This submission was made with {key} {was}, and {now} is installed."
            raise BenchError(
                "mixed-versions", message, str(path), "Physics depends on it; choose another --out."
            )


def manifest(
    existing: Mapping[str, Any], card: Mapping[str, Any], new: Mapping[str, Any], first: int, last: int
) -> dict[str, Any]:
    """All tables in order: what its author wrote stays, the rest is the run's."""
    memory = existing.get("memory", {})
    observes = {key: card[key] for key in SECTIONS["observes"]}
    ours = {
        "format": FORMAT,
        "title": existing.get("title", card["title"] or card["algorithm"]),
        "authors": existing.get("authors", []),
        "description": existing.get("description", card["description"]),
        "code": existing.get("code", {"url": "", "commit": ""}),
        "protocol": new["protocol"],
        "hyperparameters": new["hyperparameters"],
        "observes": existing.get("observes", observes),
        "memory": {
            "stored_steps": max(memory.get("stored_steps", 0), card["stored_steps"]),
            "parameters_first": max(memory.get("parameters_first", 0), first),
            "parameters_last": max(memory.get("parameters_last", 0), last),
        },
        "versions": new["versions"],
    }
    return ours | {key: value for key, value in existing.items() if key not in ours}


def write(path: Path, tables: Mapping[str, Any]) -> None:
    """Writes the manifest."""
    write_text(path, tomli_w.dumps(dict(tables)))
