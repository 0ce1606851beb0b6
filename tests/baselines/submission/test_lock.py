"""Locks: one process per job, waiting writers, and processes that end without releasing a lock."""

from __future__ import annotations

import errno
import os
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest

from gym_extensions.baselines import train
from gym_extensions.baselines.submission import lock as module
from gym_extensions.baselines.submission.lock import lock, lock_all
from gym_extensions.errors import BenchError

HOLD = """
import sys, time
from pathlib import Path
from gym_extensions.baselines.submission.lock import lock
with lock(Path(sys.argv[1]), sys.argv[2]):
    print("held", flush=True)
    time.sleep(300)
"""


def test_a_run_that_another_process_trains_is_refused_until_that_process_ends(tmp_path: Path) -> None:
    out = tmp_path / "mine"
    command = [sys.executable, "-c", HOLD, str(out), "pusher joint-run1"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "held\n"
        with pytest.raises(BenchError) as error:
            train("zero", "pusher", "joint", "smoke", [0, 1], out=out)
        assert error.value.code == "two-writers"
        assert str(error.value) == (
            f"{out}: 'pusher joint-run1' is being written by process {process.pid} on "
            f"{socket.gethostname()}. Wait until that process has finished or end it, choose other runs, or "
            "choose another --out."
        )
        assert not (out / "pusher").exists()
        train("zero", "pusher", "joint", "smoke", 0, out=out)
        process.kill()
    train("zero", "pusher", "joint", "smoke", 1, out=out)
    rows = (out / "pusher/joint.csv").read_text().splitlines()[1:]
    assert {row.partition(",")[0] for row in rows} == {"0", "1"}


def test_all_locks_are_released_if_one_is_held(tmp_path: Path) -> None:
    with (
        lock(tmp_path, "b"),
        pytest.raises(BenchError, match="'b' is being written by process"),
        lock_all(tmp_path, ["a", "b"]),
    ):
        pass
    with lock_all(tmp_path, ["a", "b"]):
        pass


def test_the_jobs_of_a_run_share_a_lock(tmp_path: Path) -> None:
    train("zero", "pusher", "single", "smoke", [0, 1], out=tmp_path / "mine")
    locks = sorted(path.name for path in (tmp_path / "mine/.progress/locks").iterdir())
    assert locks == ["pusher single-run0.lock", "pusher single-run1.lock", "write.lock"]


@pytest.mark.skipif(os.name == "nt", reason="Windows has no limit that a process can set")
def test_too_many_open_files_are_a_named_error(tmp_path: Path) -> None:
    import resource

    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(soft, 256), hard))
    try:
        with pytest.raises(BenchError) as error, lock_all(tmp_path, map(str, range(300))):
            pass
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
    assert error.value.code == "too-many-runs"
    assert str(error.value).endswith(
        "Too many open files. Train fewer groups or runs in one call, or raise the limit (ulimit -n)."
    )
    with lock_all(tmp_path, map(str, range(300))):
        pass


def test_a_lock_can_be_waited_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    held = lock(tmp_path, "write")
    held.__enter__()
    pauses: list[float] = []

    def release(seconds: float) -> None:
        pauses.append(seconds)
        if len(pauses) == 3:
            held.__exit__(None, None, None)

    monkeypatch.setattr(time, "sleep", release)
    with lock(tmp_path, "write", seconds=60):
        assert len(pauses) == 3


@pytest.mark.skipif(os.name == "nt", reason="file systems without locks are those of other systems")
def test_a_file_system_without_locks_gives_a_warning(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(_: int) -> None:
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(module, "_try_lock", refuse)
    with (
        pytest.warns(RuntimeWarning, match=r"has no locks \(No locks available\)\. Let only one process"),
        lock(tmp_path, "write"),
    ):
        pass
