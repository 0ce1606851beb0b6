"""A full disk or a broken manifest while runs are written: nothing is lost, and nothing written in part."""

from __future__ import annotations

import errno
import shutil
from pathlib import Path

import pytest

from gym_extensions.baselines import train
from gym_extensions.baselines.training.events import Event, StageStarted
from gym_extensions.errors import BenchError

from ..conftest import QUICK_GROUP, digests


@pytest.fixture(scope="module")
def first_run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """random, joint, run 0."""
    folder = tmp_path_factory.mktemp("first-run") / "random"
    train("random", QUICK_GROUP, "joint", "smoke", 0, out=folder)
    return folder


@pytest.fixture(scope="module")
def three_runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """random, joint, runs 0, 1 and 2 at once."""
    folder = tmp_path_factory.mktemp("three-runs") / "random"
    train("random", QUICK_GROUP, "joint", "smoke", [0, 1, 2], out=folder)
    return folder


def refuse_training(event: Event) -> None:
    assert not isinstance(event, StageStarted), "a finished stage was repeated"


@pytest.mark.parametrize("name", ["joint.csv", ".npz", "submission.toml"])
def test_a_full_disk_leaves_the_submission_as_it_was_and_the_run_can_be_written_later(
    name: str, first_run: Path, three_runs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = Path(shutil.copytree(first_run, tmp_path / "mine"))
    before, write = digests(out), Path.write_bytes

    def fill_disk(path: Path, content: bytes) -> int:
        if f"{name}." in path.name and "staged" in path.parts:
            write(path, content[:10])
            raise OSError(errno.ENOSPC, "No space left on device")
        return write(path, content)

    with monkeypatch.context() as patch:
        patch.setattr(Path, "write_bytes", fill_disk)
        with pytest.raises(BenchError) as error:
            train("random", QUICK_GROUP, "joint", "smoke", [1, 2], out=out)
    cause = "The disk is full: No space left on device. Free some disk space."
    assert [line.strip() for line in error.value.message.splitlines()] == [
        "2 of 2 jobs failed.",
        *(f"{QUICK_GROUP.name} joint-run{run}: {cause}" for run in (1, 2)),
    ]
    assert error.value.hint.endswith("The same command continues; it reuses 2 finished stages.")
    assert digests(out) == before
    assert not list(out.rglob("*.partial"))
    train("random", QUICK_GROUP, "joint", "smoke", [1, 2], out=out, callback=refuse_training)
    assert digests(out) == digests(three_runs)


def test_a_manifest_that_breaks_during_training_fails_the_runs_that_it_meets_and_loses_none(
    first_run: Path, three_runs: Path, tmp_path: Path
) -> None:
    out = Path(shutil.copytree(first_run, tmp_path / "mine"))
    manifest = (out / "submission.toml").read_bytes()

    def edit(event: Event) -> None:
        if isinstance(event, StageStarted):
            (out / "submission.toml").write_text("title = ")

    with pytest.raises(BenchError) as error:
        train("random", QUICK_GROUP, "joint", "smoke", [1, 2], out=out, callback=edit)
    assert error.value.code == "jobs-failed"
    assert error.value.message.startswith("2 of 2 jobs failed.")
    assert error.value.hint.endswith("The same command continues; it reuses 2 finished stages.")
    (out / "submission.toml").write_bytes(manifest)
    train("random", QUICK_GROUP, "joint", "smoke", [1, 2], out=out, callback=refuse_training)
    assert digests(out) == digests(three_runs)
