"""Runs are logged again from their policies, and keep what they say of the training."""

from pathlib import Path

import msgspec
import pytest

from gym_extensions.submissions.run import read_run
from tools import record_again

from ..verification.made_submissions import GROUP, change_documents, change_log, copy, honest

PLACE = f"{GROUP}/sequential"


@pytest.fixture
def old(tmp_path: Path) -> Path:
    """A submission whose episodes have other returns, of another arithmetic."""
    submission = copy(honest(runs=2), tmp_path / "mine")
    change_log(submission, lambda row: {"return": row["return"] * (1 - 1e-9)})
    change_documents(submission, lambda _: {"arithmetic": 1, "command": "train", "cpu_seconds": 5.0})
    return submission


def files(submission: Path, suffix: str) -> list[bytes]:
    return [path.read_bytes() for path in sorted((submission / PLACE).glob(f"*{suffix}"))]


@pytest.mark.usefixtures("in_this_process")
def test_the_log_is_that_of_the_policies_and_the_document_keeps_the_training(
    old: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = read_run(old / PLACE / "run0.json")
    arguments = [str(old), "--cache", str(old.parent / "cache")]
    assert record_again.main([*arguments, "--runs", f"{PLACE}/run1"]) == 0
    assert [run.arithmetic for run in map(read_run, sorted((old / PLACE).glob("*.json")))] == [1, 2]
    assert record_again.main(arguments) == 0
    assert capsys.readouterr().out.splitlines()[1].startswith(f"{PLACE}/run0: largest change")
    assert files(old, ".csv") == files(honest(runs=2), ".csv")
    after = read_run(old / PLACE / "run0.json")
    assert msgspec.structs.replace(before, log=after.log, arithmetic=2) == after


@pytest.mark.usefixtures("in_this_process")
def test_a_run_that_cannot_be_written_stays_as_it_was(old: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = files(old, ".csv"), files(old, ".json")

    def full(*_: object) -> None:
        raise OSError("No space left on device")

    monkeypatch.setattr("gym_extensions.submissions.run.write_run", full)
    with pytest.raises(OSError, match="No space"):
        record_again.main([str(old), "--cache", str(old.parent / "cache")])
    assert (files(old, ".csv"), files(old, ".json")) == before
