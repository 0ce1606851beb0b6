"""Writes the logs, curves, traces and manifest of a submission from finished jobs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from gym_extensions.baselines.submission import manifest
from gym_extensions.baselines.submission.lock import write_lock
from gym_extensions.baselines.submission.root import require_bound, require_unsalted, traces_root
from gym_extensions.baselines.submission.rows import logged_runs, read_curves, read_episodes, read_evaluations
from gym_extensions.baselines.submission.sample import (
    find_traces,
    remove_other_traces,
    sample_names,
    stage_traces,
    trace_folders,
)
from gym_extensions.baselines.submission.staging import move_into_place, staging
from gym_extensions.baselines.training.jobs import Settings, TrainingJob, jobs_of
from gym_extensions.baselines.training.policies import policies_folder
from gym_extensions.baselines.training.progress import FinishedStage, Progress
from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.rollouts.episodes import write_curves, write_episodes, write_evaluations
from gym_extensions.rollouts.layout import (
    CURVES,
    EVALUATIONS,
    MANIFEST,
    POLICIES,
    TRACES,
    policy_names,
)


def missing_jobs(out: Path, group: TaskGroup, protocol: str, runs: Sequence[int]) -> list[TrainingJob]:
    """The jobs of the runs that are not yet in the log. Folders of jobs that are in it are deleted."""
    logged = logged_runs(_log(out, group, protocol))
    for job in jobs_of(group, protocol, sorted(logged)):
        Progress.of(out, job).remove()
    missing = [run for run in runs if run not in logged]
    if missing:
        require_extensible(out, group, protocol)
    return jobs_of(group, protocol, missing)


def require_extensible(out: Path, group: TaskGroup, protocol: str) -> None:
    """Raises ``BenchError`` if no run can be added to a log.

    Its rows name no traces, a salt has drawn the traces of its group, or a trace of the sample is missing.
    """
    require_bound(out)
    require_unsalted(out, group.name)
    path = _log(out, group, protocol)
    if path.exists():
        _traces(out, group, protocol, path)


def write_log(
    out: Path,
    group: TaskGroup,
    protocol: str,
    finished: dict[TrainingJob, list[FinishedStage]],
    settings: Settings,
) -> None:
    """Adds runs to a log with their curves, traces and policies, then deletes the folders of their jobs.

    All files are written to a temporary folder and then moved, the log last, so that a full disk leaves the
    submission as it was and an interrupted call can be repeated. Waits for another process that writes
    files of the submission.

    Raises:
        BenchError: the log has changed since the jobs started, so that no run can be added.
    """
    with write_lock(out):
        require_extensible(out, group, protocol)
        _write_log(out, group, protocol, finished, settings)
        for job in finished:
            Progress.of(out, job).remove()


def _write_log(
    out: Path,
    group: TaskGroup,
    protocol: str,
    finished: dict[TrainingJob, list[FinishedStage]],
    settings: Settings,
) -> None:
    runs = {job.run for job in finished}
    path, ids = _log(out, group, protocol), group.task_ids
    records = [record for stages in finished.values() for record in stages]
    rows = [row for row in read_episodes(path) if row.run not in runs]
    rows += [row for record in records for row in record.episodes]
    curves, evaluations = path.with_name(CURVES), path.with_name(EVALUATIONS)
    points = [row for row in read_curves(curves) if row.protocol != protocol or row.run not in runs]
    points += [point for record in records for point in record.curves]
    interim = [
        row for row in read_evaluations(evaluations) if row.protocol != protocol or row.run not in runs
    ]
    interim += [row for record in records for row in record.evaluations]

    with staging(out) as staged:
        folder = staged / group.name
        write_episodes(folder / path.name, rows, ids)
        traces = _traces(out, group, protocol, folder / path.name)
        stage_traces(traces, path.with_name(TRACES), folder / TRACES)
        if points:
            write_curves(folder / CURVES, points, ids)
        if interim:
            write_evaluations(folder / EVALUATIONS, interim, ids)
        root = traces_root(staged, out)
        _write_manifest(out / MANIFEST, staged / MANIFEST, records, settings, root)
        _move_policies(out, group, protocol, sorted({row.run for row in rows}))
        move_into_place(staged, out, last=Path(group.name, path.name))
    remove_other_traces(traces, path.with_name(TRACES), protocol)


def _log(out: Path, group: TaskGroup, protocol: str) -> Path:
    return out / group.name / f"{protocol}.csv"


def _traces(out: Path, group: TaskGroup, protocol: str, log: Path) -> dict[str, Path]:
    """The traces of a log's audit sample by file name."""
    runs = sorted(logged_runs(log))
    names = sample_names(group, protocol, log.read_bytes(), runs)
    return find_traces(names, trace_folders(out, group.name), f"{group.name}/{protocol}.csv")


def _move_policies(out: Path, group: TaskGroup, protocol: str, runs: Sequence[int]) -> None:
    """Moves the policies of a log into the submission, or back if one is missing: a log has all or none."""
    unfinished, published = policies_folder(out, group.name), out / group.name / POLICIES
    names = policy_names(protocol, runs, group)
    is_complete = all((unfinished / name).exists() or (published / name).exists() for name in names)
    source, target = (unfinished, published) if is_complete else (published, unfinished)
    moved = [name for name in names if (source / name).exists()]
    for name in moved:
        target.mkdir(parents=True, exist_ok=True)
        (source / name).replace(target / name)
    if moved and not any(source.iterdir()):
        source.rmdir()


def _write_manifest(
    path: Path, target: Path, records: Sequence[FinishedStage], settings: Settings, root: str
) -> None:
    existing = manifest.read(path)
    card = max((record.card for record in records), key=lambda card: card.stored_steps)
    new = manifest.run_sections(
        card, settings.budget, settings.num_envs, settings.observes, steps=settings.steps
    )
    manifest.require_same(path, existing, new)
    first, last = (max(record.parameters[end] for record in records) for end in (0, 1))
    kernels = [record.blas for record in records]
    tables = manifest.merge(existing, card, new, first, last, kernels=kernels) | {"traces": {"root": root}}
    manifest.write(target, tables)
