"""Runs jobs in this process or in worker processes with one thread each. A job that fails stops no other."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from multiprocessing.process import BaseProcess
from queue import Empty
from typing import Any, Protocol, TypeVar

from gym_extensions.baselines.execution.failures import WORKER_DIED, Failure, failure_of
from gym_extensions.baselines.training.events import Event, Listener

ONE_THREAD = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
"""Environment variables that libraries read when a process loads them."""
POLL_SECONDS = 0.2
LAST_EVENT_SECONDS = 0.5

Result_co = TypeVar("Result_co", covariant=True)
Result = TypeVar("Result")


class Runnable(Protocol[Result_co]):
    """Something that a worker process can run. It must pickle."""

    def run(self, listen: Listener) -> Result_co:
        """Runs to the end and reports progress to ``listen``."""


class Executor(Protocol):
    """Runs many things; ``slots`` is the number that run at the same time."""

    @property
    def slots(self) -> int: ...

    def run(
        self, pending: Sequence[Runnable[Result]], listen: Listener
    ) -> Iterator[tuple[int, Result | Failure]]:
        """Yields each index with its result or failure, in the order of finishing.

        Args:
            pending: what to run.
            listen: called with every event in this process. Its exceptions stop everything.
        """


@dataclass(frozen=True)
class ThisProcess:
    """Runs one after another in this process."""

    slots: int = 1

    def run(
        self, pending: Sequence[Runnable[Result]], listen: Listener
    ) -> Iterator[tuple[int, Result | Failure]]:
        """Yields each index with its result or failure, in order."""

        def report(event: Event) -> None:
            try:
                listen(event)
            except Exception as error:
                raise _ListenerFailed from error

        for index, runnable in enumerate(pending):
            outcome: Result | Failure
            try:
                outcome = runnable.run(report)
            except _ListenerFailed as stopped:
                assert stopped.__cause__ is not None
                raise stopped.__cause__ from stopped.__cause__.__cause__
            except Exception as error:  # noqa: BLE001  (an agent may raise anything)
                outcome = failure_of(error, in_this_process=True)
            yield index, outcome


class _ListenerFailed(BaseException):
    """A listener raised an exception, the cause of this one. It passes ``except Exception`` of an agent."""


@dataclass(frozen=True)
class Workers:
    """Runs up to ``slots`` worker processes, which run one thing at a time: a killed worker fails one only.

    Workers are spawned, not forked, on every platform.
    """

    slots: int

    def run(
        self, pending: Sequence[Runnable[Result]], listen: Listener
    ) -> Iterator[tuple[int, Result | Failure]]:
        """Yields each index with its result or failure, in the order of finishing."""
        os.environ.update(dict.fromkeys(ONE_THREAD, "1"))
        waiting = deque(range(len(pending)))
        running: dict[Future[Result | Failure], tuple[int, _Worker]] = {}

        def start(worker: _Worker) -> None:
            index = waiting.popleft()
            running[worker.submit(index, pending[index])] = (index, worker)

        try:
            while waiting and len(running) < self.slots:
                start(_Worker())
            while running:
                done = wait(running, timeout=POLL_SECONDS, return_when=FIRST_COMPLETED).done
                for future, (_, worker) in running.items():
                    # A worker sends its last events from a separate thread, a moment after its result.
                    worker.forward(listen, LAST_EVENT_SECONDS if future in done else 0.0)
                for future in done:
                    index, worker = running.pop(future)
                    outcome = _outcome(future)
                    if waiting:
                        start(worker if future.exception() is None else _Worker())
                    else:
                        worker.pool.shutdown(wait=False)
                    yield index, outcome
        except BaseException:
            for _, worker in running.values():
                worker.stop()
            raise


class _Worker:
    """A worker process and its queue of events. A killed worker could leave a shared queue locked."""

    def __init__(self) -> None:
        context = multiprocessing.get_context("spawn")
        self._events = context.Queue()
        self._index: int | None = None  # of the job whose events are still to come
        self.pool = ProcessPoolExecutor(
            1, mp_context=context, initializer=_initialize, initargs=(self._events,)
        )
        self._processes: list[BaseProcess] = []

    def submit(self, index: int, runnable: Runnable[Result]) -> Future[Result | Failure]:
        """Runs a job, whose index is not that of the job before; the first call starts the process."""
        self._index, others = index, multiprocessing.active_children()
        future = self.pool.submit(_run, index, runnable)
        self._processes += [each for each in multiprocessing.active_children() if each not in others]
        return future

    def stop(self) -> None:
        """Ends the process, whatever it runs."""
        self.pool.shutdown(wait=False, cancel_futures=True)
        for process in self._processes:
            process.terminate()

    def forward(self, listen: Listener, timeout: float) -> None:
        """Passes on the events that have arrived; waits up to a timeout for the job's last one, None."""
        while self._index is not None:
            try:
                index, event = self._events.get(timeout=timeout) if timeout else self._events.get_nowait()
            except Empty:
                return
            if event is not None:
                listen(event)
            elif index == self._index:
                self._index = None


def _outcome(future: Future[Result | Failure]) -> Result | Failure:
    error = future.exception()
    if error is None:
        return future.result()
    return Failure(WORKER_DIED) if isinstance(error, BrokenProcessPool) else failure_of(error)


_events: Any = None


def _initialize(events: Any) -> None:
    global _events  # noqa: PLW0603  (the only way to pass a pool's initializer arguments on)
    _events = events
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # on Ctrl-C, the parent process stops its workers
    threading.Thread(target=_exit_with_parent, daemon=True).start()


def _exit_with_parent() -> None:
    """Ends this worker as soon as the parent process has ended, even if it was killed."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _run(index: int, runnable: Runnable[Any]) -> Any:
    try:
        return runnable.run(lambda event: _events.put((index, event)))
    except (Exception, SystemExit) as error:  # noqa: BLE001  (an agent may raise anything)
        return failure_of(error)
    finally:
        _events.put((index, None))
