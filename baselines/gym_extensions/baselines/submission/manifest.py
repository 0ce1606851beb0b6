"""Writes ``submission.toml``, with sections that follow from a run and sections that the author edits."""

from __future__ import annotations

import platform
import tomllib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import tomli_w

from gym_extensions.atomic import write_text
from gym_extensions.baselines.agent import Card, Observes
from gym_extensions.baselines.training.versions import BETWEEN, UNKNOWN, job_versions, joined
from gym_extensions.envs.fingerprint import require_published_engine
from gym_extensions.errors import BenchError
from gym_extensions.installed import blas_kernels, version
from gym_extensions.rollouts.manifest import FORMAT, PACKAGES, RECORDED, Steps
from gym_extensions.rollouts.manifest_values import SHORT

SHARED_SECTIONS = ("protocol", "hyperparameters", "observes")
"""Sections that are the same in every run of a submission."""
DEFAULTS = {"protocol": {"steps": RECORDED}}
"""Values of keys that a manifest may leave out."""
PHYSICS_PACKAGES = ("gymnasium", "mujoco")
"""Packages whose versions are the same in every run of a submission."""
BLAS = "blas"
"""The key of the BLAS kernels in the section ``versions``. Manifests before it do not have it."""
ONE_SETTING = (
    "A submission has one algorithm, one budget and one set of hyperparameters; choose another --out."
)
DERIVED = "This section follows from the agent's attribute observes. Change that, or choose another --out."

Tables = Mapping[str, Any]


def versions() -> dict[str, str]:
    """The versions of the packages, of Python and of the platform, and the BLAS kernels of this process."""
    return job_versions() | {
        "python": platform.python_version(),
        "platform": f"{platform.system()}-{platform.machine()}",
        BLAS: blas_kernels(),
    }


def stated_blas(tables: Tables) -> str:
    """The BLAS kernels that a manifest states, ``unknown`` if it has versions without them."""
    return str(tables["versions"].get(BLAS, UNKNOWN)) if "versions" in tables else ""


def read(path: Path) -> dict[str, Any]:
    """The manifest's tables, empty if the file does not exist. Raises ``BenchError`` if it is not TOML."""
    if not path.exists():
        return {}
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        hint = "Correct the file, or choose another --out."
        raise BenchError("bad-manifest", f"The file is not valid TOML: {error}.", str(path), hint) from error


def run_sections(
    card: Card, budget: str, num_envs: int | None, observes: Observes, *, steps: Steps = "recorded"
) -> dict[str, Any]:
    """The sections that follow from a run.

    They are ``protocol``, ``hyperparameters``, ``observes``, ``versions`` and, if the card names packages,
    ``packages``.

    Hyperparameters are as TOML reads them back (tuples as lists), so that a later run compares equal.

    Raises ``BenchError`` if the installed engine is not that of the published tasks.
    """
    require_published_engine()
    settings = dict(card.hyperparameters) | ({} if num_envs is None else {"num_envs": num_envs})
    packages = {PACKAGES: {name: version(name) for name in card.packages}} if card.packages else {}
    return packages | {
        "protocol": {
            "budget": budget,
            "algorithm": card.algorithm,
            "evaluation": card.evaluation,
            "steps": steps,
        },
        "hyperparameters": tomllib.loads(tomli_w.dumps(settings)),
        "observes": asdict(observes),
        "versions": versions(),
    }


def stated(value: object) -> str:
    """A value of a manifest in a message."""
    return "not stated" if value is None else repr(value)


def require_same(path: Path, existing: Tables, new: Tables) -> None:
    """Raises ``BenchError`` if the existing manifest differs in what must be the same in every run."""
    for section in SHARED_SECTIONS:
        old = existing.get(section)
        if old is None:
            continue
        old = DEFAULTS.get(section, {}) | old
        for key in sorted(old.keys() | new[section].keys()):
            previous, current = old.get(key), new[section].get(key)
            if previous != current:
                message = (
                    f"{section}.{key} is {stated(previous)} in this submission and {stated(current)} in the "
                    "new run."
                )
                hint = DERIVED if section == "observes" else ONE_SETTING
                raise BenchError("mixed-submission", message, str(path), hint)
    for package in PHYSICS_PACKAGES:
        previous, current = existing.get("versions", {}).get(package), new["versions"][package]
        if previous not in (None, current):
            message = f"This submission was made with {package} {previous}; {current} is installed."
            hint = f"Install {package} {previous}, or choose another --out."
            raise BenchError("mixed-versions", message, str(path), hint)


def merge(
    existing: Tables, card: Card, new: Tables, first: int, last: int, *, kernels: Iterable[str] = ()
) -> dict[str, Any]:
    """The whole manifest.

    The author's values stay, and the rest follows from the run.

    Args:
        existing: the tables of the existing manifest; may be empty.
        card: of the agent that stores the most transitions.
        new: the sections of the run.
        first: the agent's parameters before training.
        last: the agent's parameters after training.
        kernels: the BLAS kernels of the runs.
    """
    memory = existing.get("memory", {})
    blas = fitting([stated_blas(existing), *kernels])
    runs = [existing, new]
    tables = {
        "format": FORMAT,
        "title": existing.get("title", card.title or card.algorithm),
        "authors": existing.get("authors", []),
        "description": existing.get("description", card.description),
        "code": existing.get("code", {"url": "", "commit": ""}),
        "protocol": new["protocol"],
        "hyperparameters": new["hyperparameters"],
        "observes": new["observes"],
        "tuning": existing.get("tuning", {"steps": card.tuning_steps, "tasks": list(card.tuning_tasks)}),
        "memory": {
            "stored_steps": max(memory.get("stored_steps", 0), card.stored_steps),
            "parameters_first": max(memory.get("parameters_first", 0), first),
            "parameters_last": max(memory.get("parameters_last", 0), last),
        },
        "versions": columns(runs, "versions", fitting) | {BLAS: blas},
    } | ({PACKAGES: columns(runs, PACKAGES, fitting)} if PACKAGES in new else {})
    return tables | {key: value for key, value in existing.items() if key not in tables}


def columns(manifests: Sequence[Tables], section: str, combine: Callable[[list[Any]], Any]) -> dict[str, Any]:
    """Every key of a section with its values combined; a manifest may lack the section or the key."""
    present = [item.get(section, {}) for item in manifests]
    keys = dict.fromkeys(key for table in present for key in table)
    return {key: combine([table[key] for table in present if key in table]) for key in keys}


def fitting(values: Sequence[str]) -> str:
    """The distinct values as one text. ``others`` stands for the first ones if the text would be too long."""
    distinct = joined(values).split(BETWEEN)
    while len(BETWEEN.join(distinct)) > SHORT and len(distinct) > 1:
        distinct[:2] = ["others"]
    return BETWEEN.join(distinct)


def write(path: Path, tables: Tables) -> None:
    """Writes the manifest."""
    write_text(path, tomli_w.dumps(dict(tables)))
