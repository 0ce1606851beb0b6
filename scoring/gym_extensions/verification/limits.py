"""Runs a job on a stranger's files in a process of its own: limits on memory, time and files, no network.

The process is Python itself with this module. It reads a request from standard input, imports the job's
module, limits itself, and writes one line of JSON per answer. Nothing of a submission is executed in it; the
limits are for files that are made to use up memory or time, and for mistakes in the libraries that read them.
"""

import importlib
import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
import traceback
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from gym_extensions.errors import BenchError

MEBIBYTE = 2**20
KEPT_VARIABLES = (
    *("PATH", "HOME", "TMPDIR", "NUMBA_CACHE_DIR", "LD_LIBRARY_PATH", "SYSTEMROOT", "USERPROFILE", "TEMP"),
    *("OPENBLAS_CORETYPE", "NPY_DISABLE_CPU_FEATURES", "NUMBA_CPU_NAME"),  # must not matter, which is tested
)
"""Environment variables that the process gets. Tokens are not among them."""
FORBIDDEN = (
    *("socket.", "subprocess.", "os.exec", "os.posix_spawn", "os.spawn", "os.startfile"),
    *("os.system", "os.fork", "pty."),
)
"""Beginnings of the audit events that the process refuses: the network and other programs."""
TOO_SLOW = "too-slow"
"""The code of the error if the time was used up, of the processor or in all."""
MAX_ANSWER = 64 * MEBIBYTE
"""Most bytes of one answer."""


@dataclass(frozen=True)
class Limits:
    """Limits of a process: bytes of memory and of a file, seconds of processor time and of wall time."""

    memory: int = 4096 * MEBIBYTE
    file_size: int = 64 * MEBIBYTE
    cpu_seconds: int = 3600
    wall_seconds: int = 7200


READING = Limits(cpu_seconds=600, wall_seconds=600)
"""Of a process that reads the files of a submission."""


def apply_limits(limits: Limits) -> None:
    """Limits this process for the rest of its life, and refuses sockets and child processes.

    Only Linux limits the memory. Windows limits nothing but sockets and processes.
    """
    if sys.platform != "win32":
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
            later = 5 if name == resource.RLIMIT_CPU and allowed != hard else 0  # SIGXCPU says why it ended
            resource.setrlimit(name, (allowed, allowed + later))

    def refuse(event: str, _: object) -> None:
        if event.startswith(FORBIDDEN):
            raise PermissionError(f"{event} is not allowed in a process that reads files of a submission")

    sys.addaudithook(refuse)


LIVE: set[subprocess.Popen[bytes]] = set()
"""The processes that work at the moment."""


def end_all() -> None:
    """Ends all processes, so that the loops over their answers end with an error."""
    for process in tuple(LIVE):
        process.kill()


def answers(job: Callable[[Any], Iterator[Any]], request: Mapping[str, Any], limits: Limits) -> Iterator[Any]:
    """The answers of a job that runs in a process with limits, as they come. Leaving the loop ends it.

    The job is a function of a module, from a request to an iterator, all of JSON values.

    Raises:
        BenchError: raised by the job; ``too-slow``, if its time was used up; ``limit-reached``, if another
            limit ended it; or ``fault-of-the-verifier``, if the job failed in another way.
    """
    environment = {name: os.environ[name] for name in KEPT_VARIABLES if name in os.environ}
    environment |= {"OPENBLAS_NUM_THREADS": "1", "PYTHONUTF8": "1"}
    with (
        tempfile.TemporaryFile() as errors,
        tempfile.TemporaryDirectory() as folder,
        subprocess.Popen(
            [sys.executable, "-I", "-m", __name__],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=errors,
            env=environment,
            cwd=folder,
        ) as process,
    ):
        LIVE.add(process)
        timer = threading.Timer(limits.wall_seconds, process.kill)
        timer.start()
        try:
            call = {"module": job.__module__, "job": job.__name__, "request": request}
            yield from _conversation(process, {**call, "limits": asdict(limits)})
            if process.wait() != 0:
                is_slow = not timer.is_alive() or process.returncode == -getattr(signal, "SIGXCPU", 0)
                errors.seek(0)
                lines = errors.read().decode(errors="replace").strip().splitlines() or ["without a message"]
                message = f"The process ended with status {process.returncode}: {lines[-1][:200]}."
                used = f"{limits.memory // MEBIBYTE} MiB of memory and {limits.wall_seconds // 60} minutes"
                code = TOO_SLOW if is_slow else "limit-reached"
                raise BenchError(code, message, hint=f"Use smaller policies: a check has {used}.")
        finally:
            timer.cancel()
            LIVE.discard(process)
            process.kill()


def _conversation(process: subprocess.Popen[bytes], request: dict[str, Any]) -> Iterator[Any]:
    assert process.stdin is not None
    assert process.stdout is not None
    try:
        process.stdin.write(json.dumps(request).encode())
        process.stdin.close()
    except BrokenPipeError:  # its status says why
        return
    while line := process.stdout.readline(MAX_ANSWER):
        try:
            answer = json.loads(line)
        except ValueError:  # it was ended while it wrote
            process.kill()
            return
        if "error" in answer:
            raise BenchError(*answer["error"])
        yield answer["answer"]


def main() -> None:
    """Reads a request, limits this process, runs the job, and writes its answers."""
    call = json.load(sys.stdin.buffer)
    # Libraries may start programs while they are imported.
    job = getattr(importlib.import_module(call["module"]), call["job"])
    apply_limits(Limits(**call["limits"]))
    try:
        for answer in job(call["request"]):
            _write({"answer": answer})
    except BenchError as error:
        _write({"error": [error.code, error.message, error.where, error.hint]})
    except (MemoryError, OSError):  # a limit
        raise
    except Exception as error:  # noqa: BLE001 - a mistake of the verifier is not one of the submission
        last = traceback.extract_tb(error.__traceback__)[-1]
        place = f"{Path(last.filename).name}, {last.name}"
        message = f"The verifier stopped with {type(error).__name__} in {place}."
        hint = "Please report it; the submission may be right."
        _write({"error": ["fault-of-the-verifier", message, "", hint]})


def _write(answer: dict[str, Any]) -> None:
    sys.stdout.buffer.write(json.dumps(answer).encode() + b"\n")
    sys.stdout.buffer.flush()


if __name__ == "__main__":
    main()
