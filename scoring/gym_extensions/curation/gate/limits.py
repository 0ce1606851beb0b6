"""Limits of the process that judges a submission: memory, processor time, file size, no network."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from typing import NoReturn

from gym_extensions.errors import BenchError

MEBIBYTE = 2**20
FORBIDDEN = (
    "socket.",
    "subprocess.",
    "os.exec",
    "os.posix_spawn",
    "os.spawn",
    "os.system",
    "os.fork",
    "pty.",
)
"""Beginnings of the audit events that the process refuses: the network and other programs."""


@dataclass(frozen=True)
class Limits:
    """Limits of a process: bytes of memory and of a file, seconds of processor time and of wall time."""

    memory: int = 4096 * MEBIBYTE
    file_size: int = 64 * MEBIBYTE
    cpu_seconds: int = 1800
    wall_seconds: int = 3600


DEFAULT = Limits()


def apply_limits(limits: Limits) -> None:
    """Limits this process for the rest of its life, and refuses sockets and child processes.

    Only Linux limits the memory.

    Raises:
        BenchError: the operating system has no such limits.
    """
    if sys.platform == "win32":
        message = "Windows has no limits on memory and processor time."
        raise BenchError("no-limits", message, "check-pr", "Run it on Linux or macOS.")
    import resource

    memory = [(resource.RLIMIT_AS, limits.memory)] if sys.platform == "linux" else []
    for name, value in (
        *memory,
        (resource.RLIMIT_FSIZE, limits.file_size),
        (resource.RLIMIT_CPU, limits.cpu_seconds),
        (resource.RLIMIT_CORE, 0),
        (resource.RLIMIT_NOFILE, 256),
    ):
        _, hard = resource.getrlimit(name)
        allowed = value if hard == resource.RLIM_INFINITY else min(value, hard)
        resource.setrlimit(name, (allowed, allowed))
    sys.addaudithook(_refuse)


def _refuse(event: str, _: object) -> None:
    if event.startswith(FORBIDDEN):
        _stop(event)


def _stop(event: str) -> NoReturn:
    raise PermissionError(f"{event} is not allowed while a submission is judged")
