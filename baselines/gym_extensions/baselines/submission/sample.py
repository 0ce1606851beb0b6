"""Collects the traces of the audit sample from the folders that may contain them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

from gym_extensions.atomic import write_bytes
from gym_extensions.baselines.training.progress import traces_folder
from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.auditing.sample import audit_sample
from gym_extensions.rollouts.layout import PROGRESS, TRACES, trace_name


def trace_folders(out: Path, group_name: str) -> tuple[Path, Path]:
    """Where a submission's traces can be: those of all episodes, if they are still there, and the sample."""
    return traces_folder(out, group_name), out / group_name / TRACES


def sample_names(
    group: TaskGroup, protocol: str, log: bytes, runs: Sequence[int], salt: str = ""
) -> dict[str, int]:
    """The file names of a log's audit sample, sorted, each with its run."""
    names = {task.id: task.name for task in group.tasks}
    sample = audit_sample(protocol, log, runs, group.tasks, salt)
    files = {
        trace_name(protocol, row.run, row.stage, names[row.task], row.episode): row.run for row in sample
    }
    return dict(sorted(files.items()))


def find_traces(names: dict[str, int], folders: Sequence[Path], log: str) -> dict[str, Path]:
    """The first file of each name in the folders.

    Args:
        names: file names with their runs.
        folders: the folders to search, in order.
        log: the log's path, for the error message.

    Raises:
        BenchError: a trace is in none of the folders.
    """
    paths = {}
    for name, run in names.items():
        path = next((folder / name for folder in folders if (folder / name).exists()), None)
        if path is None:
            raise BenchError(
                "traces-lost",
                f"The audit sample of run {run} in {log} needs the trace {name}, which is missing.",
                where=str(folders[-1]),
                hint=f"Run gym-extensions trace, restore the traces of all episodes in {PROGRESS}, or train "
                "all runs in another --out.",
            )
        paths[name] = path
    return paths


def copy_traces(paths: dict[str, Path], target: Path, protocol: str) -> None:
    """Makes ``target`` contain these traces of the protocol and no others."""
    stage_traces(paths, target, target)
    remove_other_traces(paths, target, protocol)


def stage_traces(paths: dict[str, Path], target: Path, staged: Path) -> None:
    """Copies the traces that are not yet in ``target`` to ``staged``."""
    for name, path in paths.items():
        if path != target / name:
            write_bytes(staged / name, path.read_bytes())


def remove_other_traces(names: Iterable[str], target: Path, protocol: str) -> None:
    """Deletes the traces of the protocol that do not have one of these names."""
    expected = set(names)
    for path in target.glob(f"{protocol}-*.npz"):
        if path.name not in expected:
            path.unlink()
