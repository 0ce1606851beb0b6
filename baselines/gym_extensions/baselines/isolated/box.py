"""Starts a guest in a box: bubblewrap with namespaces of its own, and two pipes. Says why it ended."""

import json
import os
import platform
import re
import select
import shutil
import signal
import subprocess
import sys
import time
import weakref
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict
from importlib.util import find_spec
from itertools import chain
from operator import eq
from pathlib import Path
from typing import Any

import msgspec

from gym_extensions.baselines import algorithms, generators, workers
from gym_extensions.baselines.isolated import confine, contents, frames
from gym_extensions.errors import BenchError
from gym_extensions.submissions.manifest import BOX_PACKAGES
from gym_extensions.submissions.problem import cut, escape

GUEST = """
import json, sys
from gym_extensions.baselines.isolated.confine import Limits, confine
limits = Limits(**json.loads(sys.argv[3]))
confine(limits)  # before a library starts a thread
from gym_extensions.baselines.isolated.guest import Guest
Guest(int(sys.argv[1]), int(sys.argv[2]), limits.files).serve(b"")
"""
NAMESPACES = """--unshare-user --unshare-pid --unshare-net --unshare-ipc --unshare-uts --unshare-cgroup-try
    --uid 65534 --gid 65534 --hostname box --cap-drop ALL --die-with-parent --new-session --clearenv"""
OWN_VARIABLES = {
    "PYTHONPATH": contents.PACKAGES,
    "PYTHONHOME": contents.PYTHON,
    "LD_LIBRARY_PATH": f"{contents.PYTHON}/lib",
    "PYTHONHASHSEED": "0",
    "PYTHONUTF8": "1",
    "LANG": "C.UTF-8",
    "HOME": "/tmp",
    "PATH": "",
}
OPTION, REPORT = "--isolated", "Please report it, with where Python and its packages come from."
ALLOW = "On Ubuntu, allow it with: sudo sysctl -w kernel.apparmor_restrict_unprivileged_userns=0"
TAIL, LINES, WIDTH = 16_384, 10, 160
"""Of what a guest prints: the bytes that are kept, the lines that an error shows, and their length."""
PIPE_BYTES, FORBIDDEN = 2**20, "made a system call of x32"


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


def hint_of(text: str) -> str:
    """What to do about the exception of an agent. The text is the guest's, the hint the world's."""
    missing = re.match(r"ModuleNotFoundError: No module named '(\w+)", text)
    if missing and (module := missing[1]) not in {name.replace("-", "_") for name in BOX_PACKAGES}:
        return f"A box has {', '.join(BOX_PACKAGES)}, and no simulator (docs/isolated.md)."
    if missing and find_spec(module) is None and (extra := algorithms.missing_extra(module)):
        return f"A box has what is installed. {extra[1]}"
    return "Correct it; without --isolated, Python shows more."


def command(agent: Path | None, limits: confine.Limits, pipes: tuple[int, int]) -> list[str]:
    """The command line that starts a guest which reads from and writes to these pipes."""
    # The number of threads is the world's, because results depend on it.
    variables = {name: os.environ.get(name, "1") for name in workers.ONE_THREAD} | OWN_VARIABLES
    if kernels := os.environ.get("OPENBLAS_CORETYPE"):
        variables["OPENBLAS_CORETYPE"] = kernels
    options = [
        *(("--setenv", name, value) for name, value in variables.items()),
        *contents.mounts(agent),
        ("--size", str(limits.files), "--tmpfs", "/tmp", "--chdir", "/tmp", "--remount-ro", "/"),
        ("--", f"{contents.PYTHON}/bin/python", "-S", "-P", "-B", "-c", GUEST),
    ]
    arguments = [*map(str, pipes), json.dumps(asdict(limits))]
    return ["bwrap", *NAMESPACES.split(), *chain.from_iterable(options), *arguments]


class Box:
    """A running guest, and the conversation with it: commands and their replies.

    Args:
        name: what errors call the agent.
        agent: the stranger's file, or None for one of this project's agents.
        limits: of the guest.

    Every method raises ``BenchError`` if the guest has ended, has used up a limit, or sends what no frame
    allows, with the place and what the agent printed last; the class does if no box can be started.
    """

    def __init__(self, name: str, agent: Path | None, limits: confine.Limits) -> None:
        require_possible()
        import fcntl  # Windows has none

        self.name, self.limits = name, limits
        self._where: str | Callable[[], str] = ""  # it has not started
        self._printed, self._total, self._waited = b"", 0, 0.0
        self._scopes: list[tuple[int, int | None]] = []
        (theirs_in, writer), (reader, theirs_out), (self._output, output) = (os.pipe() for _ in range(3))
        try:
            self._process = subprocess.Popen(
                command(agent, limits, (theirs_in, theirs_out)),
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=output,
                pass_fds=(theirs_in, theirs_out),
                env={"PATH": os.environ.get("PATH", os.defpath)},
            )
        finally:
            for end in (theirs_in, theirs_out, output):
                os.close(end)
        ours = (reader, writer, self._output)
        weakref.finalize(self, _end, self._process, ours)
        for end in ours:
            os.set_blocking(end, False)
        with suppress(OSError):  # larger pipes only save time
            fcntl.fcntl(writer, fcntl.F_SETPIPE_SZ, PIPE_BYTES)
        me = weakref.proxy(self)  # without a cycle, the guest ends as soon as nobody holds its box
        self.pipe = frames.Pipe(reader, writer, lambda writing: me._wait(writing))  # noqa: PLW0108
        self._polls = (select.poll(), select.poll())  # while reading, while writing
        for poll, end, event in zip(self._polls, ours[:2], (select.POLLIN, select.POLLOUT), strict=True):
            poll.register(end, event)
            poll.register(self._output, select.POLLIN)
        with self.at(""):
            if self.pipe.read_kind() != frames.STARTED:
                raise frames.ProtocolError("it does not start")

    def ask(
        self, where: str, name: str, *arguments: Any, blob: bytes = b"", limit: int = 0
    ) -> tuple[Any, bytearray]:
        """Sends a command. Returns its reply: JSON, and at most ``limit`` bytes. Errors name ``where``."""
        with self.at(where):
            self.send(name, *arguments, blob=blob)
            return self.reply(self.pipe.read_kind(), limit)

    def send(self, name: str, *arguments: Any, blob: bytes = b"") -> None:
        """Sends a command: the name of a method of the guest, and its arguments."""
        self.synchronize()
        self.pipe.write_message(frames.COMMAND, (name, arguments), blob)

    def synchronize(self) -> None:
        """Lets the guest's global random generators be seeded and kept where the world's are."""
        if (wanted := generators.SCOPES) != self._scopes:
            same = sum(map(eq, wanted, self._scopes))  # their numbers are unique, so equal ones come first
            opened = [seed for _, seed in wanted[same:]]
            self.pipe.write_message(frames.COMMAND, ("scopes", (len(self._scopes) - same, opened)))
            self._scopes = wanted.copy()
            self.reply(self.pipe.read_kind(), 0)

    def reply(self, kind: bytes, limit: int) -> tuple[Any, bytearray]:
        """The rest of a reply whose kind was read. Raises ``BenchError`` if the agent raised an exception."""
        if kind == frames.ERROR:
            text = cut(escape(str(self.pipe.read_message(0)[0])))
            message = f"The agent raised {text}{'' if text.endswith(('.', '?')) else '.'}"
            raise self.error("agent-failed", message, hint_of(text))
        if kind != frames.REPLY:
            raise frames.ProtocolError(f"the unexpected byte {kind!r}")
        return self.pipe.read_message(limit)

    @contextmanager
    def at(self, where: str | Callable[[], str]) -> Iterator[None]:
        """Errors inside name this place, or what the function gives when they are raised."""
        before, self._where = self._where, where
        try:
            yield
        except EOFError:
            raise self._ended() from None
        except (frames.ProtocolError, msgspec.ValidationError) as error:
            hint = "Use only the arguments of make, act and learn, and smaller policies."
            message = f"The agent's process sent what no frame allows: {error}."
            raise self.error("agent-frames", message, hint) from None
        self._where = before

    def used(self) -> tuple[float, float]:
        """Processor time in seconds and peak memory in MB, summed over the box's processes; 0 after its end.

        The kernel outside of the box counts both. Files in the box's ``/tmp`` do not count as memory.
        """
        ticks, kilobytes, waiting = 0, 0, [str(self._process.pid)]
        with suppress(OSError, ValueError):
            while waiting:
                process = Path(f"/proc/{waiting.pop()}")
                stat = (process / "stat").read_text().rpartition(")")[2].split()
                ticks += sum(map(int, stat[11:15]))  # its own in user and system mode, and of ended children
                peak = (process / "status").read_text().partition("VmHWM:")[2].split()
                kilobytes += int(peak[0]) if peak else 0  # a process that has ended has none
                waiting += (process / "task" / process.name / "children").read_text().split()
        return ticks / os.sysconf("SC_CLK_TCK"), kilobytes / 1e3

    def _wait(self, writing: bool) -> None:
        """Waits until the guest has done something, and takes what it has printed."""
        begun, left = time.monotonic(), self.limits.longest_wait - self._waited
        ready = dict(self._polls[writing].poll(1000 * max(left, 0.0)))
        self._waited += time.monotonic() - begun
        if not ready:
            message = f"The agent let the training wait for {self.limits.longest_wait:,} seconds."
            raise self.error("agent-slow", message, "Wait for nothing but the environment.")
        if self._output in ready and not self._take_output():
            for poll in self._polls:  # it closed its output
                poll.unregister(self._output)
        if self._total > self.limits.output:
            message = f"The agent printed more than {self.limits.output:,} bytes."
            raise self.error("agent-output", message, "Print less.")

    def _take_output(self) -> int:
        data = os.read(self._output, TAIL)
        self._printed, self._total = (self._printed + data)[-TAIL:], self._total + len(data)
        return len(data)

    def _ended(self) -> BenchError:
        """Why the process has ended."""
        try:
            code = self._process.wait(timeout=2)
        except subprocess.TimeoutExpired:
            return self.error("agent-ended", "The agent closed its pipes.", "Leave open files alone.")
        if not self._where:
            last = (self._last_lines() or ["without a message"])[-1].rstrip(".")
            if not last.startswith("bwrap: "):
                return BenchError("no-box", f"Python does not start in the box: {last}.", OPTION, REPORT)
            message = f"Bubblewrap cannot start a box: {last.removeprefix('bwrap: ')}."
            return BenchError("no-box", message, OPTION, f"{ALLOW}. Otherwise see docs/isolated.md.")
        if code == 128 + signal.SIGXCPU:
            message = f"The agent used up its {self.limits.cpu_seconds:,} seconds of processor time."
            hint = "Compute less: the limit is five times what trpo takes, and a minute."
            return self.error("agent-cpu", message, hint)
        causes = {128 + signal.SIGKILL: "was killed, as if memory ran out", 128 + signal.SIGSYS: FORBIDDEN}
        message = f"The agent's process {causes.get(code, f'ended with status {code}')}."
        return self.error("agent-ended", message, "Return from make, act and learn, and do not end Python.")

    def error(self, code: str, message: str, hint: str) -> BenchError:
        """An error with the place and what the agent printed last. Ends the guest."""
        self._process.kill()
        lines = self._last_lines()
        shown = "".join(f"\n  | {line}" for line in lines)
        printed = f" It printed last:{shown}\n" if lines else ""
        where = self._where() if callable(self._where) else self._where
        return BenchError(code, f"{message}{printed}", f"{self.name}, {where or 'at its start'}", hint)

    def _last_lines(self) -> list[str]:
        with suppress(OSError):  # nothing is left
            while self._total <= self.limits.output and self._take_output():
                pass
        lines = [line for line in self._printed.decode("utf-8", "replace").splitlines() if line.strip()]
        return [escape(line[: 2 * WIDTH])[:WIDTH] for line in lines[-LINES:]]


def _end(process: subprocess.Popen[bytes], pipes: tuple[int, ...]) -> None:
    """Ends a guest; also called when nobody holds its box any more, and when the world ends."""
    process.kill()
    process.wait()
    for end in pipes:
        os.close(end)
