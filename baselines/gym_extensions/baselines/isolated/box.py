"""Starts a guest in a box: bubblewrap with namespaces of its own, and two pipes. Says why it ended."""

from __future__ import annotations

import fcntl
import json
import os
import platform
import select
import shutil
import subprocess
import sys
import time
import weakref
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict
from itertools import chain
from pathlib import Path

from gym_extensions.baselines.isolated import contents, frames
from gym_extensions.baselines.isolated.confine import Limits
from gym_extensions.errors import BenchError
from gym_extensions.submissions.problem import escape

GUEST = """
import json, sys
from gym_extensions.baselines.isolated.confine import Limits, confine
limits = Limits(**json.loads(sys.argv[3]))
confine(limits)  # before a library starts a thread
from gym_extensions.baselines.isolated.guest import Guest
Guest(int(sys.argv[1]), int(sys.argv[2]), limits.files).serve(b"")
"""
PASSED = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
"""Environment variables on which results depend; 1 if the world does not set them."""
OPTION, REPORT = "--isolated", "Please report it, with where Python and its packages come from."
ALLOW = "On Ubuntu, allow it with: sudo sysctl -w kernel.apparmor_restrict_unprivileged_userns=0"
TAIL, LINES, WIDTH = 16_384, 10, 160
"""Of what a guest prints: the bytes that are kept, the lines that an error shows, and their length."""
PIPE_BYTES = 2**20


def require_possible() -> None:
    """Raises ``BenchError``, which says how to go on, where no box can be started."""
    if sys.platform != "linux" or platform.machine() != "x86_64":
        message = f"A box needs Linux on x86-64; this is {platform.system()} on {platform.machine()}."
        raise BenchError("no-box", message, OPTION, "Use a container, as docs/isolated.md shows.")
    if 0 in (os.getuid(), os.geteuid()):
        message = "The command runs as root, and what root starts can write files of the kernel."
        hint = "Run it as an ordinary user, for example with: sudo -u USER gym-extensions train …"
        raise BenchError("box-as-root", message, OPTION, hint)
    if shutil.which("bwrap") is None:
        hint = "Install it, for example with: sudo apt-get install bubblewrap"
        raise BenchError("no-box", "Bubblewrap, which makes the box, is not installed.", OPTION, hint)


def command(agent: Path | None, limits: Limits, pipes: tuple[int, int]) -> list[str]:
    """The command line that starts a guest which reads from and writes to these pipes."""
    variables = {name: os.environ.get(name, "1") for name in PASSED} | {
        **{"PYTHONPATH": contents.PACKAGES, "PYTHONHOME": contents.PYTHON, "PYTHONUTF8": "1"},
        **{"PYTHONHASHSEED": "0", "LD_LIBRARY_PATH": f"{contents.PYTHON}/lib"},
        **{"HOME": "/tmp", "TMPDIR": "/tmp", "LANG": "C.UTF-8", "PATH": ""},
    }
    if kernels := os.environ.get("OPENBLAS_CORETYPE"):
        variables["OPENBLAS_CORETYPE"] = kernels
    options = (
        ("--unshare-user", "--unshare-pid", "--unshare-net", "--unshare-ipc", "--unshare-uts"),
        (
            "--unshare-cgroup-try",
            "--uid",
            "65534",
            "--gid",
            "65534",
            "--hostname",
            "box",
            "--cap-drop",
            "ALL",
        ),
        ("--die-with-parent", "--new-session", "--clearenv"),
        *(("--setenv", name, value) for name, value in variables.items()),
        *contents.mounts(agent),
        ("--size", str(limits.files), "--tmpfs", "/tmp", "--chdir", "/tmp", "--remount-ro", "/"),
    )
    guest = (f"{contents.PYTHON}/bin/python", "-S", "-P", "-B", "-c", GUEST)
    arguments = (*map(str, pipes), json.dumps(asdict(limits)))
    return ["bwrap", *chain.from_iterable(options), "--", *guest, *arguments]


class Box:
    """A running guest, which answers on ``pipe``.

    Args:
        name: what errors call the agent.
        agent: the stranger's file, or None for one of this project's agents.
        limits: of the guest.

    Raises ``BenchError`` if no box can be started.
    """

    def __init__(self, name: str, agent: Path | None, limits: Limits) -> None:
        require_possible()
        self.name, self.limits = name, limits
        self.where: Callable[[], str] = lambda: "at its start"
        self._tail, self._printed, self._waited = b"", 0, 0.0
        from_world, writer = os.pipe()
        reader, to_world = os.pipe()
        self._output, output = os.pipe()
        theirs = (from_world, to_world)
        try:
            self._process = subprocess.Popen(
                command(agent, limits, theirs),
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=output,
                pass_fds=theirs,
                env={"PATH": os.environ.get("PATH", os.defpath)},
            )
        finally:
            for end in (*theirs, output):
                os.close(end)
        ours = (reader, writer, self._output)
        self.end = weakref.finalize(self, _end, self._process, ours)
        for end in ours:
            os.set_blocking(end, False)
        with suppress(OSError):  # larger pipes only save time
            fcntl.fcntl(writer, fcntl.F_SETPIPE_SZ, PIPE_BYTES)
        self.pipe = frames.Pipe(reader, writer, self._wait)
        self._polls = (select.poll(), select.poll())  # while reading, while writing
        for poll, end, event in zip(
            self._polls, (reader, writer), (select.POLLIN, select.POLLOUT), strict=True
        ):
            poll.register(end, event)
            poll.register(self._output, select.POLLIN)
        self._started = False
        with self.verdicts():
            if self.pipe.read_kind() != frames.STARTED:
                raise frames.ProtocolError("something else than its start")
        self._started = True

    def _wait(self, writing: bool) -> None:
        """Waits until the guest has done something, and takes what it has printed."""
        begun, left = time.monotonic(), self.limits.longest_wait - self._waited
        ready = dict(self._polls[writing].poll(1000 * max(left, 0.0)))
        self._waited += time.monotonic() - begun
        if not ready:
            message = f"The agent let the training wait for {self.limits.longest_wait:,} seconds."
            raise self.error("agent-slow", message, "Wait for nothing but the environment.")
        if self._output in ready:
            self._drain()

    def _drain(self) -> None:
        data = os.read(self._output, 2**16)
        if not data:
            for poll in self._polls:
                poll.unregister(self._output)
        self._tail, self._printed = (self._tail + data)[-TAIL:], self._printed + len(data)
        if self._printed > self.limits.output:
            self._printed = 0
            message = f"The agent printed more than {self.limits.output:,} bytes."
            raise self.error("agent-output", message, "Print less.")

    def cpu_seconds(self) -> float:
        """The processor time of all processes of the box so far; 0 once it has ended."""
        ticks, waiting = 0, [str(self._process.pid)]
        with suppress(OSError, ValueError):
            while waiting:
                process = Path(f"/proc/{waiting.pop()}")
                stat = (process / "stat").read_text().rpartition(")")[2].split()
                ticks += sum(map(int, stat[11:15]))  # its own in user and system mode, and of ended children
                waiting += (process / "task" / process.name / "children").read_text().split()
        return ticks / os.sysconf("SC_CLK_TCK")

    @contextmanager
    def verdicts(self) -> Iterator[None]:
        """Raises ``BenchError`` where the guest ends or sends what no frame allows."""
        try:
            yield
        except EOFError:
            raise self._ended() from None
        except frames.ProtocolError as error:
            message = f"The agent's process sent {error}."
            raise self.error(
                "agent-frames", message, "Use only the arguments of make, act and learn."
            ) from None

    def _ended(self) -> BenchError:
        """Why the process has ended."""
        deadline = time.monotonic() + 2
        while (reaped := os.wait4(self._process.pid, os.WNOHANG))[0] == 0 and time.monotonic() < deadline:
            time.sleep(0.01)
        if reaped[0] == 0:
            return self.error("agent-ended", "The agent closed its pipes.", "Leave open files alone.")
        _, status, usage = reaped
        code, seconds = os.waitstatus_to_exitcode(status), usage.ru_utime + usage.ru_stime
        self._process.returncode = code
        if not self._started:
            last = (self._lines() or ["without a message"])[-1]
            if not last.startswith("bwrap: "):
                return BenchError("no-box", f"Python does not start in the box: {last}", OPTION, REPORT)
            message = f"Bubblewrap cannot start a box: {last.removeprefix('bwrap: ').rstrip('.')}."
            return BenchError("no-box", message, OPTION, f"{ALLOW}. Otherwise see docs/isolated.md.")
        if seconds >= self.limits.cpu_seconds - 1:
            message = f"The agent used up its {self.limits.cpu_seconds:,} seconds of processor time."
            return self.error("agent-cpu", message, "That is five times what trpo takes, and a minute.")
        cause = {137: "was killed, as if memory ran out", 159: "made a system call that is not allowed"}
        message = f"The agent's process {cause.get(code, f'ended with status {code}')}."
        return self.error("agent-ended", message, "Return from make, act and learn, and do not end Python.")

    def error(self, code: str, message: str, hint: str) -> BenchError:
        """An error with the place and what the agent printed last. The guest is ended."""
        self._process.kill()
        with suppress(BlockingIOError, ValueError, KeyError, OSError):
            while self._printed <= self.limits.output:
                before = self._printed
                self._drain()
                if self._printed == before:
                    break
        lines = self._lines()
        shown = "".join(f"\n  | {line}" for line in lines)
        printed = f" It printed last:{shown}\n" if lines else ""
        return BenchError(code, f"{message}{printed}", f"{self.name}, {self.where()}", hint)

    def _lines(self) -> list[str]:
        lines = [line for line in self._tail.decode("utf-8", "replace").splitlines() if line.strip()]
        return [escape(line[: 2 * WIDTH])[:WIDTH] for line in lines[-LINES:]]


def _end(process: subprocess.Popen[bytes], pipes: tuple[int, ...]) -> None:
    """Ends a guest; also called when nobody holds its box any more, and when the world ends."""
    process.kill()
    process.wait()
    for end in pipes:
        os.close(end)
