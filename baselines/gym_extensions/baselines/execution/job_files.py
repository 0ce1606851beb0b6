"""The files of one job as bytes, so that a job can run on a machine without a shared file system."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from gym_extensions.atomic import write_bytes
from gym_extensions.baselines.training.events import Listener
from gym_extensions.baselines.training.jobs import TrainingJob
from gym_extensions.baselines.training.progress import FinishedStage, Progress
from gym_extensions.baselines.training.runner import PendingJob
from gym_extensions.rollouts.layout import POLICIES, PROGRESS, TRACES

Files = Mapping[str, bytes]
"""Contents by path relative to the folder ``.progress/<group>`` of a submission, with slashes."""


@dataclass(frozen=True)
class RemoteJob:
    """A job that runs in a temporary folder, from the files of its finished stages to all of its files."""

    pending: PendingJob
    files: Files

    def run(self, listen: Listener) -> Files:
        """Runs the job and returns its files."""
        job = self.pending.job
        with tempfile.TemporaryDirectory(prefix="gym-extensions-") as folder:
            out = Path(folder) / "job"
            store_files(out, job, self.files)
            replace(self.pending, out=out).run(listen)
            return read_files(out, job)


def read_files(out: Path, job: TrainingJob) -> dict[str, bytes]:
    """The files of a job in the submission's folder ``out``: stages, the saved agent, traces and policies."""
    group = out / PROGRESS / job.group.name
    paths = [*_of_job(group, job), *(group / job.name).glob("*.json"), *(group / job.name).glob("agent*.npz")]
    return {path.relative_to(group).as_posix(): path.read_bytes() for path in sorted(paths)}


def store_files(out: Path, job: TrainingJob, files: Files) -> list[FinishedStage]:
    """Moves the files of a job into place: its traces and policies, then its folder as a whole.

    Returns:
        The records of its finished stages.
    """
    group = out / PROGRESS / job.group.name
    incoming, target = group / f".{job.name}.incoming", group / job.name
    shutil.rmtree(incoming, ignore_errors=True)
    incoming.mkdir(parents=True)
    try:
        for name, content in files.items():
            folder, _, file = name.rpartition("/")
            write_bytes((incoming if folder == job.name else group / folder) / file, content)
        shutil.rmtree(target, ignore_errors=True)
        incoming.replace(target)
    finally:
        shutil.rmtree(incoming, ignore_errors=True)
    return Progress(target).finished()


def _of_job(group: Path, job: TrainingJob) -> Iterable[Path]:
    """The traces and policies of a job."""
    start = f"{job.protocol}-run{job.run}-"
    for folder in (TRACES, POLICIES):
        if job.task is None:
            yield from (group / folder).glob(f"{start}*.npz")
        else:
            name = f"{start}stage1-{job.group.tasks[job.task].name}"
            yield from (group / folder).glob(f"{name}.npz")
            yield from (group / folder).glob(f"{name}-episode*.npz")
