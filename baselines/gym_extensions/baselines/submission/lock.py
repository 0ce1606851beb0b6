"""Locks that let several processes write one submission: one process per run, and one writer at a time.

The operating system releases a lock when its process ends, however it ends, so a lock is never stale. The
file of a lock stays; it names the last process that held it.
"""

from __future__ import annotations

import errno
import os
import socket
import sys
import time
import warnings
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from gym_extensions.errors import BenchError
from gym_extensions.rollouts.layout import PROGRESS

WRITE_SECONDS = 300.0
"""How long a process waits for another one that writes the files of the submission."""
POLL_SECONDS = 0.05
LOCK_BYTE = 2**30
"""The byte that Windows locks, far behind the text that other processes read."""

if sys.platform == "win32":
    import msvcrt

    def _try_lock(descriptor: int) -> None:
        os.lseek(descriptor, LOCK_BYTE, os.SEEK_SET)
        msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
        os.lseek(descriptor, 0, os.SEEK_SET)
else:
    import fcntl

    def _try_lock(descriptor: int) -> None:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)


@contextmanager
def lock(out: Path, name: str, *, seconds: float = 0.0) -> Iterator[None]:
    """Holds a lock of the submission's folder ``out``.

    Args:
        out: the folder; its ``.progress/locks`` contains the files of the locks.
        name: what is locked: a run's or a stage's title, or ``write``.
        seconds: how long to wait for another process.

    Raises:
        BenchError: another process holds the lock, or this process has too many open files.
    """
    path = out / PROGRESS / "locks" / f"{name}.lock"
    path.parent.mkdir(parents=True, exist_ok=True)
    try:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT)
    except OSError as error:
        if error.errno != errno.EMFILE:
            raise
        hint = "Train fewer groups or runs in one call, or raise the limit (ulimit -n)."
        raise BenchError("too-many-runs", f"{error.strerror}.", str(path), hint) from error
    try:
        _acquire(descriptor, path, name, time.monotonic() + seconds)
        holder = f"process {os.getpid()} on {socket.gethostname()}".encode()
        os.ftruncate(descriptor, 0)
        os.write(descriptor, holder)
        yield
    finally:
        os.close(descriptor)


@contextmanager
def lock_all(out: Path, names: Iterable[str]) -> Iterator[None]:
    """Holds the locks of several runs, or raises ``BenchError`` and holds none."""
    with ExitStack() as locks:
        for name in names:
            locks.enter_context(lock(out, name))
        yield


def write_lock(out: Path) -> ExitStack:
    """Holds the lock of the finished files; waits for another process that writes them."""
    locks = ExitStack()
    locks.enter_context(lock(out, "write", seconds=WRITE_SECONDS))
    return locks


def _acquire(descriptor: int, path: Path, name: str, deadline: float) -> None:
    while True:
        try:
            _try_lock(descriptor)
        except (BlockingIOError, PermissionError) as busy:
            if time.monotonic() >= deadline:
                raise _two_writers(path, name) from busy
            time.sleep(POLL_SECONDS)
        except OSError as error:
            warnings.warn(
                f"{path.parent}: the file system has no locks ({error.strerror}). "
                "Let only one process at a time write this submission.",
                RuntimeWarning,
                stacklevel=2,
            )
            return
        else:
            return


def _two_writers(path: Path, name: str) -> BenchError:
    holder = path.read_text(encoding="utf-8", errors="replace") or "another process"
    message = f"{name!r} is being written by {holder}."
    hint = "Wait until that process has finished or end it, choose other runs, or choose another --out."
    return BenchError("two-writers", message, str(path.parents[2]), hint)
