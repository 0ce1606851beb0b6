"""Runs jobs in this process or in worker processes with one thread each. A job that fails stops no other."""

import errno
import multiprocessing
import os
import signal
import sys
import threading
import traceback
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any, Protocol

import cloudpickle

from gym_extensions.baselines.training.progress import Event, Listener
from gym_extensions.errors import BenchError

JOBS_FAILED = "jobs-failed"
"""The code of the error that ``train`` raises after the other jobs have finished."""
DISK_FULL = (errno.ENOSPC, errno.EDQUOT)
WORKER_DIED = "The worker process was ended by {}. If memory ran out, use fewer --jobs or --num-envs."
EXITED = "The worker process ended with status {} before its job did; it printed why."
NO_GUARD = 86  # the exit status of a worker that runs the user's script instead of its job
GUARD = "Worker processes import the script: put the call of train under `if __name__ == '__main__':`."


@dataclass(frozen=True)
class Failure:
    """Why a job failed."""

    cause: str  # the error in one sentence
    traceback: str = ""
    error: BaseException | None = None  # if the job ran in this process
    code: str = ""  # of a BenchError


def failure_of(error: BaseException, *, in_this_process: bool = False) -> Failure:
    """The failure of a job that raised an exception, as text, because not every exception pickles."""
    try:
        cause = str(error) if isinstance(error, BenchError) else f"{type(error).__name__}: {error}"
    except Exception:  # noqa: BLE001  (its own __str__ may raise)
        cause = type(error).__name__
    cause = cause.rstrip(": ")
    if isinstance(error, OSError) and error.errno in DISK_FULL:
        cause = f"The disk is full: {error.strerror}. Free some disk space."
    text = "".join(traceback.format_exception(error))
    code = error.code if isinstance(error, BenchError) else ""
    is_raised = in_this_process and isinstance(error, Exception)  # SystemExit would end the caller
    return Failure(cause, text, error if is_raised else None, code)


def require_sendable(agent: object) -> None:
    """Raises ``BenchError`` if a worker process cannot receive an agent, as one that holds a lock.

    Classes and functions of a notebook or a script are sent with their code (cloudpickle).
    """
    try:
        cloudpickle.dumps(agent)
    except Exception as error:
        reason = f"{type(error).__name__}: {error}".rstrip(".")
        message = f"A worker process cannot receive the agent: {reason}."
        hint = "Put it in a module (a .py file) and import it from there, or train with jobs=0."
        raise BenchError("bad-agent", message, "agent", hint) from error


def jobs_failed(failures: Mapping[str, Failure], total: int, hint: str) -> BenchError:
    """The error that names every failed job, by its title, with its cause. ``total`` counts all jobs."""
    jobs = "1 job" if total == 1 else f"{total} jobs"
    lines = [f"{len(failures)} of {jobs} failed."]
    lines += [f"  {title}: {failure.cause}" for title, failure in failures.items()]
    return BenchError(JOBS_FAILED, "\n".join([*lines, ""]), hint=hint)


ONE_THREAD = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
"""Environment variables that libraries read when a process loads them."""


class Runnable(Protocol):
    """Something that a worker process can run. cloudpickle must be able to send it."""

    def run(self, listen: Listener) -> Any:
        """Runs to the end, reports progress to ``listen`` and returns a result."""


Outcomes = Iterator[tuple[int, Any]]
"""The index of each runnable with its result, or with a ``Failure``."""


def run(pending: Sequence[Runnable], listen: Listener, jobs: int) -> Outcomes:
    """Runs each in a worker process, at most ``jobs`` at a time; with 0, one after another in this process.

    ``listen`` is called with every event in this process. Its exceptions stop everything.
    """
    return _run_in_workers(pending, listen, jobs) if jobs else _run_here(pending, listen)


def _run_here(pending: Sequence[Runnable], listen: Listener) -> Outcomes:
    of_listener: list[Exception] = []

    def report(event: Event) -> None:
        try:
            listen(event)
        except Exception as error:
            of_listener.append(error)
            raise

    for index, runnable in enumerate(pending):
        try:
            outcome = runnable.run(report)
        except (Exception, SystemExit) as error:  # noqa: BLE001  (an agent may raise anything)
            outcome = failure_of(error, in_this_process=True)
        if of_listener:
            raise of_listener[0]
        yield index, outcome


def _run_in_workers(pending: Sequence[Runnable], listen: Listener, jobs: int) -> Outcomes:
    """One process each, so that a killed worker fails one only; spawned, not forked, on every platform."""
    os.environ.update(dict.fromkeys(ONE_THREAD, "1"))
    main = vars(sys.modules["__main__"])
    if not Path(main.get("__file__") or "").is_file():
        main.pop("__file__", None)  # `python < script`: a worker cannot import "<stdin>"
    context, waiting = multiprocessing.get_context("spawn"), deque(enumerate(pending))
    running: dict[Any, tuple[int, BaseProcess]] = {}  # by the connection to the process
    process: Any
    connection: Any
    value: Any
    try:
        while waiting or running:
            while waiting and len(running) < jobs:
                index, runnable = waiting.popleft()
                here, there = context.Pipe(duplex=False)
                try:
                    process = context.Process(target=_work, args=(there, cloudpickle.dumps(runnable)))
                    process.start()
                except Exception as error:  # noqa: BLE001  (it does not pickle)
                    yield index, failure_of(error)
                else:
                    running[here] = (index, process)
                there.close()
            for connection in wait(list(running)) if running else ():
                index, process = running[connection]
                try:
                    is_event, value = connection.recv()
                except (EOFError, OSError):  # it ended, perhaps while it was sending
                    process.join()
                    cause = GUARD if process.exitcode == NO_GUARD else EXITED.format(process.exitcode)
                    if process.exitcode < 0:
                        cause = WORKER_DIED.format(signal.Signals(-process.exitcode).name)
                    is_event, value = False, Failure(cause)
                if is_event:
                    listen(value)
                else:
                    del running[connection]
                    process.join()
                    yield index, value
    finally:  # after an error
        for _, process in running.values():
            process.terminate()


def _work(connection: Connection, pickled: bytes) -> None:
    """Runs a pickled thing in a worker process, and sends events and, last, the result."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # on Ctrl-C, the parent process stops its workers

    def exit_with_parent() -> None:  # at once, even if it was killed
        if parent := multiprocessing.parent_process():
            parent.join()
            os._exit(1)

    threading.Thread(target=exit_with_parent, daemon=True).start()
    try:
        runnable: Runnable = cloudpickle.loads(pickled)
        outcome = runnable.run(lambda event: connection.send((True, event)))
    except BaseException as error:  # noqa: BLE001  (an agent may raise anything)
        outcome = failure_of(error)
    connection.send((False, outcome))
