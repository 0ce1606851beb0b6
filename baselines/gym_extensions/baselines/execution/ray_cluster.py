"""Runs jobs on an existing Ray cluster. It needs the extra ``cluster`` (docs/cluster.md)."""

from __future__ import annotations

import os
import socket
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from gym_extensions.baselines.execution.failures import Failure, failure_of
from gym_extensions.baselines.execution.job_files import Files, RemoteJob
from gym_extensions.baselines.execution.remote import Remote
from gym_extensions.baselines.execution.workers import ONE_THREAD
from gym_extensions.baselines.training.events import Event, Listener
from gym_extensions.errors import BenchError

CONNECT_SECONDS = 5.0
"""How long to wait for the address."""
EVENT_SECONDS = 1.0
"""A job sends its events at most once in this time."""
MAX_RETRIES = 5
"""How often a job is started again because its node died."""
HINT = "Start a cluster with `ray start --head`, or correct the address; docs/cluster.md has examples."


@contextmanager
def ray_cluster(address: str) -> Iterator[Remote]:
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
    module: Any = ray
    try:
        ray.init(address=address, **options)
    except (OSError, RuntimeError, ValueError) as error:
        raise _unreachable(address, str(error).partition("\n")[0]) from error
    try:
        slots = max(1, int(module.cluster_resources().get("CPU", 1)))
        yield Remote(_Submission(module), slots)
    finally:
        ray.shutdown()


def _require_reachable(address: str) -> None:
    """Raises ``BenchError`` if nothing listens at ``host:port``; Ray itself waits for minutes."""
    target = os.environ.get("RAY_ADDRESS", "auto") if address == "auto" else address
    host, colon, port = target.removeprefix("ray://").rpartition(":")
    if target in ("auto", "local"):
        return
    if not (host and colon and port.isdigit()):
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


@dataclass(frozen=True)
class _Submission:
    """Submits jobs to the cluster that the module ``ray`` is connected to."""

    ray: Any

    def __call__(self, jobs: Sequence[RemoteJob], listen: Listener) -> Iterator[tuple[int, Files | Failure]]:
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
