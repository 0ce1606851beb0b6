"""Runs jobs in parallel worker processes with one thread each, or one after another in this process."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from multiprocessing.queues import Queue
from queue import Empty
from typing import Any, Protocol, TypeVar

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


def run_all(
    pending: Sequence[Runnable[Result]], processes: int, listen: Listener
) -> Iterator[tuple[int, Result]]:
    """Runs everything and yields each index with its result, in the order of finishing.

    The first exception stops all workers. Workers are spawned, not forked, on every platform.

    Args:
        pending: what to run.
        processes: number of worker processes; 0 runs everything in order in this process.
        listen: called with every event.
    """
    if not processes:
        for index, runnable in enumerate(pending):
            yield index, runnable.run(listen)
        return
    if not pending:
        return
    os.environ.update(dict.fromkeys(ONE_THREAD, "1"))
    context = multiprocessing.get_context("spawn")
    events: Queue[Event] = context.Queue()
    pool = ProcessPoolExecutor(
        min(processes, len(pending)), mp_context=context, initializer=_initialize, initargs=(events,)
    )
    try:
        futures = {pool.submit(_run, runnable): index for index, runnable in enumerate(pending)}
        yield from _as_completed(futures, events, listen)
        pool.shutdown()
    except BaseException:
        workers = multiprocessing.active_children()
        pool.shutdown(wait=False, cancel_futures=True)
        for process in workers:
            process.terminate()
        raise


def _as_completed(
    futures: dict[Future[Result], int], events: Queue[Event], listen: Listener
) -> Iterator[tuple[int, Result]]:
    running = set(futures)
    while running:
        done, running = wait(running, timeout=POLL_SECONDS, return_when=FIRST_COMPLETED)
        # A worker sends its last events from a separate thread, a moment after its result.
        _forward(events, listen, 0.0 if running else LAST_EVENT_SECONDS)
        for future in done:
            yield futures[future], future.result()


def _forward(events: Queue[Event], listen: Listener, timeout: float) -> None:
    while True:
        try:
            listen(events.get(timeout=timeout) if timeout else events.get_nowait())
        except Empty:
            return


_events: Queue[Event] | None = None


def _initialize(events: Queue[Event]) -> None:
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


def _run(runnable: Runnable[Any]) -> Any:
    queue = _events
    return runnable.run(lambda event: None if queue is None else queue.put(event))
