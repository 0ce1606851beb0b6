"""Runs jobs on an existing Ray cluster, without a shared file system (docs/cluster.md)."""

from __future__ import annotations

import os
import shutil
import socket
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from gym_extensions.baselines.execution.workers import ONE_THREAD, Failure, failure_of
from gym_extensions.baselines.training.checkpoints import FinishedStage, Progress
from gym_extensions.baselines.training.events import Event, Listener
from gym_extensions.baselines.training.jobs import job_versions, version_difference
from gym_extensions.baselines.training.runner import PendingJob
from gym_extensions.errors import BenchError
from gym_extensions.files import replace_folder

Files = Mapping[str, bytes]
"""Contents by name, of the folder of an unfinished job."""


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
        return cls(pending, read_files(pending), job_versions(pending.settings.packages))

    def run(self, listen: Listener) -> Files:
        """Runs the job and returns its files.

        Raises:
            BenchError: this machine has other versions of the packages than the process that sent the job.
        """
        if difference := version_difference(self.versions, self.pending.settings.packages):
            node = socket.gethostname()
            message = f"{node} has other packages than the machine that sends the jobs: {difference}."
            hint = "Install the same versions on every node."
            raise BenchError("other-version", message, self.pending.job.title, hint)
        with tempfile.TemporaryDirectory(prefix="gym-extensions-") as folder:
            here = replace(self.pending, out=Path(folder) / "job")
            store_files(here, self.files)
            here.run(listen)
            return read_files(here)


def read_files(pending: PendingJob) -> dict[str, bytes]:
    """The files of a job in the folder of its submission: stages, policies, the saved agent."""
    folder = Progress.of(pending.out, pending.job).folder
    paths = sorted(path for path in folder.glob("[!.]*") if path.suffix in (".json", ".npz"))
    return {path.name: path.read_bytes() for path in paths}


def store_files(pending: PendingJob, files: Files) -> list[FinishedStage]:
    """Puts the files of a job in place, its folder as a whole. Returns the records of its finished stages."""
    progress = Progress.of(pending.out, pending.job)
    incoming = progress.folder.with_name(f".{pending.job.name}.incoming")
    shutil.rmtree(incoming, ignore_errors=True)
    incoming.mkdir(parents=True)
    try:
        for name, content in files.items():
            (incoming / name).write_bytes(content)
        replace_folder(progress.folder, incoming)
    finally:
        shutil.rmtree(incoming, ignore_errors=True)
    return progress.finished()


class Remote:
    """An executor of training jobs that share no file system with this process.

    Args:
        slots: number of jobs that run at the same time.
    """

    def __init__(self, slots: int) -> None:
        self.slots = slots

    def submit(self, jobs: Sequence[RemoteJob], listen: Listener) -> Iterator[tuple[int, Files | Failure]]:
        """Runs jobs anywhere and yields each index with the job's files or its failure."""
        raise NotImplementedError

    def run(
        self, pending: Sequence[PendingJob], listen: Listener
    ) -> Iterator[tuple[int, list[FinishedStage] | Failure]]:
        """Yields each index with the job's stages, whose files are in place, or its failure."""
        if not pending:
            return
        for index, outcome in self.submit([RemoteJob.of(each) for each in pending], listen):
            if isinstance(outcome, Failure):
                yield index, outcome
                continue
            try:
                records = store_files(pending[index], outcome)
            except OSError as error:
                yield index, failure_of(error, in_this_process=True)
            else:
                yield index, records


CONNECT_SECONDS = 5.0
"""How long to wait for the address."""
EVENT_SECONDS = 1.0
"""A job sends its events at most once in this time."""
MAX_RETRIES = 5
"""How often a job is started again because its node died."""
HINT = "Start a cluster with `ray start --head`, or correct the address; docs/cluster.md has examples."


@contextmanager
def ray_cluster(address: str) -> Iterator[RayCluster]:
    """An executor of training jobs on a Ray cluster, one CPU per thread of a job.

    Args:
        address: ``auto`` (the cluster of this machine or of ``RAY_ADDRESS``), ``host:port`` or
            ``ray://host:port``.

    Raises:
        BenchError: Ray is not installed, or the cluster cannot be reached.
    """
    try:
        import ray
    except ModuleNotFoundError as missing:
        hint = "Install it with: pip install 'gym-extensions[cluster]'"
        raise BenchError("missing-extra", "The option --ray needs ray.", "--ray", hint) from missing
    _require_reachable(address)
    environment = {"env_vars": dict.fromkeys(ONE_THREAD, "1")}
    options: dict[str, Any] = {"runtime_env": environment, "log_to_driver": False, "logging_level": "ERROR"}
    try:
        ray.init(address=address, **options)
    except (OSError, RuntimeError, ValueError) as error:
        raise _unreachable(address, str(error).partition("\n")[0]) from error
    try:
        yield RayCluster(ray)
    finally:
        ray.shutdown()


def _require_reachable(address: str) -> None:
    """Raises ``BenchError`` if nothing listens at ``host:port``; Ray itself waits for minutes."""
    target = os.environ.get("RAY_ADDRESS", "auto") if address == "auto" else address
    host, _, port = target.removeprefix("ray://").rpartition(":")
    if target in ("auto", "local"):
        return
    if not (host and port.isdigit()):
        raise BenchError("bad-ray", f"{address!r} is not an address.", "--ray", "Use auto or host:port.")
    try:
        socket.create_connection((host, int(port)), timeout=CONNECT_SECONDS).close()
    except OSError as error:
        raise _unreachable(address, error.strerror or str(error)) from error


def _unreachable(address: str, reason: str) -> BenchError:
    message = f"The Ray cluster at {address!r} cannot be reached: {reason.rstrip('.')}."
    return BenchError("ray-unreachable", message, "--ray", HINT)


def _require_cpus(ray: Any, count: int) -> None:
    """Raises ``BenchError`` if no node has that many CPUs. Ray would wait for such a node without end."""
    nodes = [node["Resources"] for node in ray.nodes() if node["Alive"]]
    largest = max((int(resources.get("CPU", 0)) for resources in nodes), default=0)
    if 0 < largest < count:  # a cluster without CPUs may be about to grow
        message = f"{count} is too large. The largest node of the cluster has {largest} CPUs."
        raise BenchError("bad-num-threads", message, "--num-threads", f"Use at most {largest}.")


class RayCluster(Remote):
    """The cluster that the module ``ray`` is connected to."""

    def __init__(self, ray: Any) -> None:
        super().__init__(max(1, int(ray.cluster_resources().get("CPU", 1))))
        self.ray = ray

    def submit(self, jobs: Sequence[RemoteJob], listen: Listener) -> Iterator[tuple[int, Files | Failure]]:
        """Submits the jobs and delivers their events until the last one has ended."""
        ray = self.ray
        node = ray.util.scheduling_strategies.NodeAffinitySchedulingStrategy(
            ray.get_runtime_context().get_node_id(), soft=False
        )
        mailbox = ray.remote(_Mailbox).options(num_cpus=0, scheduling_strategy=node).remote()
        run, options = ray.remote(_run), {"max_retries": MAX_RETRIES, "scheduling_strategy": "SPREAD"}
        threads = [job.pending.num_threads for job in jobs]
        _require_cpus(ray, max(threads))
        running = {
            run.options(num_cpus=count, **options).remote(job, mailbox): index
            for index, (job, count) in enumerate(zip(jobs, threads, strict=True))
        }
        while running:
            done, _ = ray.wait(list(running), timeout=EVENT_SECONDS)
            self._deliver(mailbox, listen)
            for reference in done:
                index = running.pop(reference)
                try:
                    outcome = ray.get(reference)
                except ray.exceptions.RayError as error:
                    reason = str(error).strip().partition("\n")[0]
                    outcome = Failure(f"Ray could not finish the job: {reason}", failure_of(error).traceback)
                yield index, outcome
        self._deliver(mailbox, listen)

    def _deliver(self, mailbox: Any, listen: Listener) -> None:
        for event in self.ray.get(mailbox.take.remote()):
            listen(event)


class _Mailbox:
    """An actor that collects the events of all jobs until the driver takes them."""

    def __init__(self) -> None:
        self._events: list[Event] = []

    def add(self, events: Sequence[Event]) -> None:
        self._events += events

    def take(self) -> list[Event]:
        events, self._events = self._events, []
        return events


def _run(job: RemoteJob, mailbox: Any) -> Files | Failure:
    """Runs a job on a node."""
    listen = _Buffer(mailbox.add.remote)
    try:
        return job.run(listen)
    except (Exception, SystemExit) as error:  # noqa: BLE001  (an agent may raise anything)
        return failure_of(error)
    finally:
        listen.flush()


class _Buffer:
    """A listener that sends events in batches."""

    def __init__(self, send: Callable[[list[Event]], object]) -> None:
        self._send, self._events, self._sent = send, list[Event](), time.monotonic()

    def __call__(self, event: Event) -> None:
        self._events.append(event)
        if time.monotonic() - self._sent >= EVENT_SECONDS:
            self.flush()

    def flush(self) -> None:
        events, self._events, self._sent = self._events, [], time.monotonic()
        self._send(events)
