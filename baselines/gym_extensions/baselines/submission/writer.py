"""Writes the logs, curves, traces and manifest of a submission from finished jobs."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path

from gym_extensions.atomic import write_bytes
from gym_extensions.baselines.submission import manifest
from gym_extensions.baselines.training.jobs import Settings, TrainingJob, jobs_of
from gym_extensions.baselines.training.policies import policies_folder
from gym_extensions.baselines.training.progress import FinishedStage, Progress
from gym_extensions.baselines.training.runner import traces_folder
from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.audit import audit_sample
from gym_extensions.rollouts.episodes import CurvePoint, Episode, write_curves, write_episodes
from gym_extensions.rollouts.layout import CURVES, MANIFEST, POLICIES, PROGRESS, policy_names, trace_name


def read_episodes(path: Path) -> list[Episode]:
    """The rows of a log that this module wrote, empty if the file does not exist."""
    if not path.exists():
        return []
    with path.open(newline="", encoding="utf-8") as file:
        return [
            Episode(
                *(int(row["run"]), int(row["stage"]), row["task"], int(row["episode"]), int(row["seed"])),
                *(int(row["length"]), float(row["return"]), row["terminated"] == "true", row["fingerprint"]),
            )
            for row in csv.DictReader(file)
        ]


def read_curves(path: Path) -> list[CurvePoint]:
    """The points of a curves file that this module wrote, empty if the file does not exist."""
    if not path.exists():
        return []
    with path.open(newline="", encoding="utf-8") as file:
        return [
            CurvePoint(row["protocol"], int(row["run"]), row["task"], int(row["step"]), float(row["return"]))
            for row in csv.DictReader(file)
        ]


def missing_jobs(out: Path, group: TaskGroup, protocol: str, runs: Sequence[int]) -> list[TrainingJob]:
    """The jobs of the runs that are not yet in the log. Folders of jobs that are in it are deleted."""
    logged = {row.run for row in read_episodes(_log(out, group, protocol))}
    for job in jobs_of(group, protocol, sorted(logged)):
        Progress.of(out, job).remove()
    missing = [run for run in runs if run not in logged]
    if missing:
        require_traces(out, group, protocol)
    return jobs_of(group, protocol, missing)


def require_traces(out: Path, group: TaskGroup, protocol: str) -> None:
    """Raises ``BenchError`` if a trace of a logged episode is missing.

    A log with more runs has another digest, which selects other episodes of the existing runs too.
    """
    folder = traces_folder(out, group.name)
    names = {task.id: task.name for task in group.tasks}
    for row in read_episodes(_log(out, group, protocol)):
        if not (folder / trace_name(protocol, row.run, row.stage, names[row.task], row.episode)).exists():
            raise BenchError(
                "traces-lost",
                f"No run can be added to {group.name}/{protocol}.csv: run {row.run} lacks traces.",
                where=str(folder),
                hint="Restore all its traces, or train all runs in another --out.",
            )


def write_log(
    out: Path,
    group: TaskGroup,
    protocol: str,
    finished: dict[TrainingJob, list[FinishedStage]],
    settings: Settings,
) -> None:
    """Writes one log and its curves, traces and manifest, then deletes the folders of its jobs.

    The log itself is written last, so that an interrupted call can be repeated.
    """
    runs = {job.run for job in finished}
    path, ids = _log(out, group, protocol), group.task_ids
    records = [record for stages in finished.values() for record in stages]
    rows = [row for row in read_episodes(path) if row.run not in runs]
    rows += [row for record in records for row in record.episodes]
    staged = out / PROGRESS / group.name / path.name
    write_episodes(staged, rows, ids)
    _write_sample(out, group, protocol, staged.read_bytes(), sorted({row.run for row in rows}))

    curves = path.with_name(CURVES)
    points = [row for row in read_curves(curves) if row.protocol != protocol or row.run not in runs]
    points += [point for record in records for point in record.curves]
    if points:
        write_curves(curves, points, ids)
    _write_manifest(out, records, settings)
    _move_policies(out, group, protocol, sorted({row.run for row in rows}))
    staged.replace(path)
    for job in finished:
        Progress.of(out, job).remove()


def _log(out: Path, group: TaskGroup, protocol: str) -> Path:
    return out / group.name / f"{protocol}.csv"


def _write_sample(out: Path, group: TaskGroup, protocol: str, log: bytes, runs: Sequence[int]) -> None:
    names = {task.id: task.name for task in group.tasks}
    sample = audit_sample(protocol, log, runs, group.tasks)
    selected = {trace_name(protocol, row.run, row.stage, names[row.task], row.episode) for row in sample}
    source, target = traces_folder(out, group.name), out / group.name / "traces"
    for name in sorted(selected):
        write_bytes(target / name, (source / name).read_bytes())
    for path in target.glob(f"{protocol}-*.npz"):
        if path.name not in selected:
            path.unlink()


def _move_policies(out: Path, group: TaskGroup, protocol: str, runs: Sequence[int]) -> None:
    """Moves the policies of a log into the submission, unless one is missing: a log has all or none."""
    source, target = policies_folder(out, group.name), out / group.name / POLICIES
    names = policy_names(protocol, runs, group)
    if not all((source / name).exists() or (target / name).exists() for name in names):
        return
    target.mkdir(exist_ok=True)
    for name in names:
        if (source / name).exists():
            (source / name).replace(target / name)


def _write_manifest(out: Path, records: Sequence[FinishedStage], settings: Settings) -> None:
    path = out / MANIFEST
    existing = manifest.read(path)
    card = max((record.card for record in records), key=lambda card: card.stored_steps)
    new = manifest.run_sections(card, settings.budget, settings.num_envs, settings.observes)
    manifest.require_same(path, existing, new)
    first, last = (max(record.parameters[end] for record in records) for end in (0, 1))
    manifest.write(path, manifest.merge(existing, card, new, first, last))
