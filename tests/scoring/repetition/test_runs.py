"""Runs repeated in several processes: the same record as in one, and an error for a process that ends."""

from __future__ import annotations

import os
import shutil
import signal
import sys
from pathlib import Path
from typing import Any

import pytest

from gym_extensions.baselines import train
from gym_extensions.errors import BenchError
from gym_extensions.scoring.repetition import runs
from gym_extensions.scoring.repetition.cli import main
from gym_extensions.scoring.repetition.digests import RunKey
from gym_extensions.scoring.repetition.record import path_of

NAME = "zero"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two groups of a deterministic agent, with a run of each protocol."""
    folder = tmp_path_factory.mktemp("submissions") / NAME
    for protocol in ("single", "sequential"):
        train("zero", ["pusher", "striker"], protocol, "smoke", [0], out=folder, progress=False)
    shutil.rmtree(folder / ".progress")
    return folder


def test_several_processes_write_the_same_record(folder: Path, tmp_path: Path) -> None:
    one, two = tmp_path / "one", tmp_path / "two"
    assert main([str(folder), "--out", str(one)]) == 0
    assert main([str(folder), "--out", str(two), "--jobs", "2"]) == 0
    assert path_of(two, NAME).read_bytes() == path_of(one, NAME).read_bytes()


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGKILL")
def test_a_process_that_is_ended_is_an_error(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(runs, "_Worker", _Ended)
    with pytest.raises(BenchError, match=r"A worker process was ended.*fewer --jobs"):
        list(runs.repeat(folder, jobs=2))


class _Ended:
    """A worker that the system ends."""

    @staticmethod
    def start(*_: Any) -> None: ...

    @staticmethod
    def repeat(_: RunKey) -> None:
        os.kill(os.getpid(), signal.SIGKILL)


def test_the_number_of_processes_is_at_least_one(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main([str(folder), "--jobs", "0"])
    assert "--jobs takes a number from 1" in capsys.readouterr().err
