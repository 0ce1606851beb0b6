"""Traces of some runs alone: which are written, which are kept, and which runs are refused."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from gym_extensions.baselines import train
from gym_extensions.baselines.tracing.cli import main
from gym_extensions.baselines.tracing.trace import trace
from gym_extensions.errors import BenchError
from gym_extensions.scoring.replay.verify import verify

from ..conftest import QUICK_GROUP, QUICK_TOML, digests

SALT = "5a" * 32


def toml(folder: Path) -> Path:
    """The file of the custom group."""
    path = folder / "quick.toml"
    path.write_text(QUICK_TOML)
    return path


def test_only_the_traces_of_the_named_runs_are_written(tmp_path: Path) -> None:
    folder = tmp_path / "quick"
    train("random", QUICK_GROUP, "single", "smoke", range(3), out=folder, progress=False)
    traces = folder / QUICK_GROUP.name / "traces"
    every = {path.name for path in traces.glob("*.npz")}
    assert main([str(folder), "--salt", SALT, "--runs", "0,2", "--groups", str(toml(tmp_path))]) == 0
    runs = {path.name.split("-")[1] for path in traces.glob("*.npz")}
    assert runs == {"run0", "run2"}
    assert verify(folder, {QUICK_GROUP.name: QUICK_GROUP}).problems == ()
    trace(folder, groups=[QUICK_GROUP], runs=())
    assert list(traces.iterdir()) == []
    trace(folder, groups=[QUICK_GROUP])
    assert {path.name for path in traces.iterdir()} == every


def test_traces_that_leave_the_submission_are_kept(tmp_path: Path) -> None:
    folder = tmp_path / "quick"
    train("random", QUICK_GROUP, "single", "smoke", range(2), out=folder, progress=False)
    before = digests(folder)
    shutil.rmtree(folder / ".progress")
    trace(folder, groups=[QUICK_GROUP], runs=[1])
    assert len(digests(folder)) < len(before)
    trace(folder, groups=[QUICK_GROUP])
    assert digests(folder) == before


def test_a_run_that_no_log_has_is_refused_and_nothing_changes(random: Path) -> None:
    before = digests(random)
    with pytest.raises(BenchError, match=r"Run 9 is not in the logs\. Choose from: 0\."):
        trace(random, runs=[0, 9])
    assert digests(random) == before


@pytest.mark.parametrize("runs", ["x", "2-1"])
def test_a_malformed_list_of_runs_is_refused(
    trpo: Path, runs: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([str(trpo), "--runs", runs]) == 2
    assert "--runs" in capsys.readouterr().err
