"""From finished units to the submission's files: rows merged, the audit sample drawn."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path

from gym_extensions.atomic import write_bytes
from gym_extensions.baselines.submission import manifest
from gym_extensions.baselines.training.jobs import Unit, units
from gym_extensions.baselines.training.progress import Finished, Progress
from gym_extensions.baselines.training.runner import Settings
from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.audit import audit_sample
from gym_extensions.rollouts.episodes import CurvePoint, Episode, write_curves, write_episodes
from gym_extensions.rollouts.layout import MANIFEST, PROGRESS, trace_name


def read_episodes(path: Path) -> list[Episode]:
    """The rows of a log that the recorder wrote; none where there is no file."""
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
    """The points of a curves file that the recorder wrote; none where there is no file."""
    if not path.exists():
        return []
    with path.open(newline="", encoding="utf-8") as file:
        return [
            CurvePoint(row["protocol"], int(row["run"]), row["task"], int(row["step"]), float(row["return"]))
            for row in csv.DictReader(file)
        ]


def runs_there(out: Path, group: str, protocol: str) -> set[int]:
    """The runs that a log holds."""
    return {row.run for row in read_episodes(out / group / f"{protocol}.csv")}


def refuse_lost_traces(out: Path, group: TaskGroup, protocol: str) -> None:
    """Raises ``BenchError`` if the log holds runs whose complete traces are not kept here.

    A longer log has another digest, which asks for other episodes of the old runs too.
    """
    kept = out / PROGRESS / group.name / "traces"
    names = {task.id: task.name for task in group.tasks}
    for row in read_episodes(out / group.name / f"{protocol}.csv"):
        if not (kept / trace_name(protocol, row.run, row.stage, names[row.task], row.episode)).exists():
            raise BenchError(
                "traces-lost",
                f"No run can be added to {group.name}/{protocol}.csv: run {row.run} lacks traces.",
                where=str(kept),
                hint="Put the complete set back there, or train all runs in another --out.",
            )


def assemble(
    out: Path, group: TaskGroup, protocol: str, finished: dict[Unit, list[Finished]], settings: Settings
) -> None:
    """Writes one log with what belongs to it; the log itself comes last, so a stop in between is made good.

    Afterwards the units' folders are removed; the complete set of traces stays beside them.
    """
    runs = {unit.run for unit in finished}
    path, ids = out / group.name / f"{protocol}.csv", group.task_ids
    records = [record for stages in finished.values() for record in stages]
    rows = [row for row in read_episodes(path) if row.run not in runs]
    rows += [row for record in records for row in record.episodes]
    staged = out / PROGRESS / group.name / path.name
    write_episodes(staged, rows, ids)
    _write_sample(out, group, protocol, staged.read_bytes(), sorted({row.run for row in rows}))

    curves = path.with_name("curves.csv")
    points = [row for row in read_curves(curves) if row.protocol != protocol or row.run not in runs]
    points += [point for record in records for point in record.curves]
    if points:
        write_curves(curves, points, ids)
    _write_manifest(out, records, settings)
    staged.replace(path)
    for unit in finished:
        Progress(out / PROGRESS / unit.group / unit.name).remove()


def _write_sample(out: Path, group: TaskGroup, protocol: str, log: bytes, runs: Sequence[int]) -> None:
    names = {task.id: task.name for task in group.tasks}
    sample = audit_sample(protocol, log, runs, group.tasks)
    chosen = {trace_name(protocol, row.run, row.stage, names[row.task], row.episode) for row in sample}
    kept, shown = out / PROGRESS / group.name / "traces", out / group.name / "traces"
    for name in sorted(chosen):
        write_bytes(shown / name, (kept / name).read_bytes())
    for stale in shown.glob(f"{protocol}-*.npz"):
        if stale.name not in chosen:
            stale.unlink()


def _write_manifest(out: Path, records: Sequence[Finished], settings: Settings) -> None:
    path = out / MANIFEST
    existing = manifest.read(path)
    largest = max(records, key=lambda record: record.card["stored_steps"]).card
    new = manifest.written(largest, settings.budget, settings.lanes)
    manifest.refuse_mixing(path, existing, new)
    first, last = (max(record.parameters[end] for record in records) for end in (0, 1))
    manifest.write(path, manifest.manifest(existing, largest, new, first, last))


def wanted(out: Path, group: TaskGroup, protocol: str, runs: Sequence[int]) -> list[Unit]:
    """The units that are still to be run or assembled; leftovers of finished ones are removed."""
    there = runs_there(out, group.name, protocol)
    for unit in units(group.name, protocol, sorted(there)):
        Progress(out / PROGRESS / unit.group / unit.name).remove()
    missing = [run for run in runs if run not in there]
    if missing:
        refuse_lost_traces(out, group, protocol)
    return units(group.name, protocol, missing)
