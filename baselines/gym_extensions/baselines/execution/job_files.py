"""The files of one job as bytes, so that a job can run on a machine without a shared file system."""

from __future__ import annotations

import shutil
import socket
import tempfile
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from gym_extensions.atomic import replace_folder, write_bytes
from gym_extensions.baselines.training.events import Listener
from gym_extensions.baselines.training.jobs import TrainingJob
from gym_extensions.baselines.training.progress import FinishedStage, Progress
from gym_extensions.baselines.training.runner import PendingJob
from gym_extensions.baselines.training.versions import job_versions, version_difference
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.layout import POLICIES, PROGRESS, TRACES

Files = Mapping[str, bytes]
"""Contents by path relative to the folder ``.progress/<group>`` of a submission, with slashes."""


@dataclass(frozen=True)
class RemoteJob:
    """A job that runs in a temporary folder, from the files of its finished stages to all of its files.

    ``versions`` are those of the packages of the process that sends it.
    """

    pending: PendingJob
    files: Files
    versions: Mapping[str, str]

    @classmethod
    def of(cls, pending: PendingJob) -> RemoteJob:
        """The job with its files and the versions of this process."""
        return cls(pending, read_files(pending.out, pending.job), job_versions(pending.settings.packages))

    def run(self, listen: Listener) -> Files:
        """Runs the job and returns its files.

        Raises:
            BenchError: this machine has other versions of the packages than the process that sent the job.
        """
        job = self.pending.job
        if difference := version_difference(self.versions, self.pending.settings.packages):
            node = socket.gethostname()
            message = f"{node} has other packages than the machine that sends the jobs: {difference}."
            hint = "Install the same versions on every node."
            raise BenchError("other-version", message, job.title, hint)
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
        replace_folder(target, incoming)
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
