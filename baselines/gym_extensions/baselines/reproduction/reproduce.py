"""Retrains one run of a submission in a temporary folder and compares it with the log."""

from __future__ import annotations

import csv
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gym_extensions.baselines import algorithms
from gym_extensions.baselines.agent import Factory
from gym_extensions.baselines.reproduction.compare import Comparison, compare
from gym_extensions.baselines.reproduction.draw import runs_of
from gym_extensions.baselines.submission import manifest
from gym_extensions.baselines.train_agent import train
from gym_extensions.catalog.custom_groups import resolve_group
from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.errors import BenchError, did_you_mean
from gym_extensions.installed import version_or_none
from gym_extensions.rollouts.layout import MANIFEST
from gym_extensions.rollouts.manifest import PACKAGES

OF_THE_MACHINE = ("versions", PACKAGES)
"""Sections that may differ from those of the submission."""


@dataclass(frozen=True)
class Reproduction:
    """The comparison, and the versions that differ: by name, in the submission and installed."""

    comparison: Comparison
    versions: dict[str, tuple[str, str]]


def reproduce(
    entry: str | Path,
    group: str | Path | TaskGroup,
    protocol: str = "sequential",
    run: int = 0,
    *,
    agent: str | Factory | None = None,
    jobs: int = 0,
    progress: bool = True,
) -> Reproduction:
    """Retrains one run of a submission and compares it with the log.

    The rows are the same bytes if the versions, the platform and the BLAS kernels are the same. Elsewhere
    :func:`~gym_extensions.baselines.reproduction.compare.compare` decides whether they agree.

    Args:
        entry: the submission's folder, which stays as it is.
        group: the name of a group, or a custom group.
        protocol: ``"sequential"``, ``"single"`` or ``"joint"``.
        run: the training seed.
        agent: the agent of the submission, as ``"module:factory"`` or a factory. The default is the reference
            agent that the manifest names.
        jobs: number of worker processes; 0 trains in this process.
        progress: whether to show the progress of training.

    Raises:
        BenchError: the submission, its log or the run does not exist, its training was not recorded, or the
            agent is another one or has other settings.
    """
    folder, tasks = Path(entry), resolve_group(group)
    tables = _tables(folder)
    agent = _reference_agent(folder, tables) if agent is None else agent
    log = f"{tasks.name}/{protocol}.csv"
    columns, logged = read_run(folder / log, run)
    with tempfile.TemporaryDirectory(prefix="gym-extensions-") as temporary:
        out = Path(temporary) / "retrained"
        # With the settings of the submission in place, training another agent or setting is refused.
        manifest.write(out / MANIFEST, {name: tables[name] for name in tables if name not in OF_THE_MACHINE})
        settings = tables["protocol"]
        try:
            train(
                *(agent, [tasks], protocol, settings["budget"], run),
                out=out,
                jobs=jobs,
                num_envs=tables["hyperparameters"].get("num_envs"),
                progress=progress,
            )
        except BenchError as error:
            if error.code != "mixed-submission":
                raise
            hint = (
                "Check out the commit in [code], or name the agent of the submission: --agent module:factory."
            )
            raise BenchError("not-reproducible", error.message, str(folder / MANIFEST), hint) from error
        _, retrained = read_run(out / log, run)
    return Reproduction(compare(logged, retrained, columns), differing_versions(tables))


def differing_versions(tables: Mapping[str, Any]) -> dict[str, tuple[str, str]]:
    """The versions that differ: by name, in the submission's manifest and installed."""
    packages = tables.get(PACKAGES, {})
    stated_versions = {manifest.BLAS: manifest.stated_blas(tables)} | tables.get("versions", {}) | packages
    installed = manifest.versions() | {name: version_or_none(name) or "none" for name in packages}
    return {
        name: (str(stated), installed[name])
        for name, stated in stated_versions.items()
        if name in installed and installed[name] != stated
    }


def read_run(path: Path, run: int) -> tuple[list[str], list[dict[str, str]]]:
    """The columns of a log, and the rows of a run as text.

    Raises:
        BenchError: the log or the run does not exist.
    """
    if not path.is_file():
        raise BenchError(
            "no-log", "The log does not exist.", str(path), "Name a group and protocol of the entry."
        )
    with path.open(newline="", encoding="utf-8") as file:
        reader = csv.DictReader(file)
        rows = [row for row in reader if int(row["run"]) == run]
    if not rows:
        runs = runs_of(path)
        hint = f"Choose one of: {', '.join(map(str, runs))}."
        raise BenchError("no-run", f"Run {run} is not in the log.", str(path), hint)
    return list(reader.fieldnames or ()), rows


def _tables(folder: Path) -> dict[str, Any]:
    path = folder / MANIFEST
    tables = manifest.read(path)
    if not tables:
        hint = "Name the folder of a submission, such as submissions/random."
        raise BenchError("no-submission", "The file does not exist.", str(path), hint)
    if tables.get("protocol", {}).get("steps", "recorded") != "recorded":
        message = "The policies were recorded, and the training was not, so it cannot be repeated."
        raise BenchError(
            "not-reproducible", message, str(path), "gym-extensions score --reevaluate checks policies."
        )
    return tables


def _reference_agent(folder: Path, tables: dict[str, Any]) -> str:
    name = str(tables.get("protocol", {}).get("algorithm", ""))
    if name in algorithms.names():
        return name
    message = f"The algorithm {name!r} is not a reference agent."
    hint = (
        did_you_mean(name, algorithms.names()) or "Name the agent of the submission: --agent module:factory."
    )
    raise BenchError("not-reproducible", message, str(folder / MANIFEST), hint)
