"""A record: what makes its files, what refuses them, and what new seeds say."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from gym_extensions.errors import BenchError
from gym_extensions.references import experts
from gym_extensions.scoring.records import Record
from gym_extensions.submissions.poses import PolicyPoses
from gym_extensions.verification.cli import main
from gym_extensions.verification.verify_record import sample, verify_record, write_expert_poses, write_record

from .made_records import HISTORY, change_card, claim_more, lower_the_bar, make_policy, make_record
from .made_submissions import VALUE


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, in_this_process: None) -> Path:
    """An empty folder of records; records run in this process."""
    lower_the_bar(monkeypatch)
    return tmp_path / "records"


def test_a_policy_becomes_a_record_that_new_seeds_confirm(folder: Path) -> None:
    record = make_record(folder)
    assert [path.name for path in sorted(record.path.parent.iterdir())] == ["mine.json", "mine.npz"]
    assert record.card.measurement.episodes == 100
    review = verify_record(record, VALUE)
    assert (review.problem, review.episodes, review.card) == ("", 100, record.digest)
    assert review.poses is not None
    assert len(review.poses.after.returns) == 100
    assert abs(review.mean - record.card.measurement.mean) < 5 * review.measurement.standard_error
    again, other = verify_record(record, VALUE), verify_record(record, "40" * 20)
    assert review.mean == again.mean != other.mean, "the seeds follow from the value"


def test_the_command_writes_the_review_once_and_in_the_process_with_limits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    lower_the_bar(monkeypatch)
    record = make_record(tmp_path / "records")
    arguments = [str(record.path.with_suffix("")), "--seeds", VALUE, "--write"]
    assert main(arguments) == 0
    assert Record(record.path).verified
    assert "Hopper/mine: a record, " in capsys.readouterr().out
    assert main(arguments) == 0
    assert "it has a review, which stands" in capsys.readouterr().out
    assert main([str(record.path.with_name("typo"))]) == 2
    assert "There is no such file" in capsys.readouterr().err


def test_a_record_that_is_worse_than_claimed_is_refused_with_both_numbers(folder: Path) -> None:
    record = claim_more(make_record(folder))
    assert "the card claims 10" in verify_record(record, VALUE).problem
    assert [error.code for error in sample(record)[1]] == ["no-record"]


def test_a_changed_card_has_no_review(folder: Path) -> None:
    record = make_record(folder)
    record.write(verify_record(record, VALUE))
    assert Record(record.path).verified
    assert not change_card(record, "A. Author", "B. Author").verified


def test_a_policy_that_does_not_beat_the_floor_is_not_written(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lower_the_bar(monkeypatch, floor=1000.0)
    with pytest.raises(BenchError, match=r"to beat the floor, 1000\.0, it needs more than") as error:
        make_record(folder)
    assert error.value.code == "no-record"
    assert not folder.exists()


@pytest.mark.parametrize(
    ("policy", "code"),
    [
        (make_policy(inputs=17), "bad-observations"),
        (make_policy(actions=6), "bad-actions"),
        (make_policy(weights=(np.zeros((2, 11, 3)),)), "bad-policy"),
    ],
)
def test_a_policy_that_does_not_fit_the_task_is_not_written(folder: Path, policy: object, code: str) -> None:
    with pytest.raises(BenchError) as error:
        make_record(folder, policy=policy)  # type: ignore[arg-type]
    assert error.value.code == code
    assert not folder.exists()


@pytest.mark.parametrize(
    ("task", "name", "authors"),
    [("Hoper", "mine", ["A"]), ("Hopper", "a.review", ["A"]), ("Hopper", "mine", [])],
)
def test_an_unknown_task_another_name_and_no_author_are_refused(
    folder: Path, task: str, name: str, authors: list[str]
) -> None:
    with pytest.raises(BenchError):
        write_record(make_policy(), task, name, authors=authors, history=HISTORY, folder=folder)
    assert not folder.exists()


def test_the_first_look_names_the_problem_of_the_card_and_that_of_the_policy(folder: Path) -> None:
    record = make_record(folder)
    change_card(record, record.card.fingerprint, "0" * 16)
    record.policy_path.write_bytes(b"no archive")
    episodes, errors = sample(Record(record.path))
    assert (episodes, [error.code for error in errors]) == (0, ["foreign-fingerprint", "bad-policy"])


def test_poses_are_written_for_an_expert_that_has_none_of_its_policy(tmp_path: Path) -> None:
    for suffix in ("json", "npz"):
        shutil.copy(experts.DATA / f"Pusher.{suffix}", tmp_path)
    (line,) = write_expert_poses(["Pusher"], tmp_path)
    path = Path(line)
    poses = PolicyPoses.load(path, "bad-poses", "")
    assert poses is not None
    assert poses.policy == experts.digest(experts.load("Pusher"))
    assert list(write_expert_poses(["Pusher"], tmp_path)) == [f"{line}: up to date"]
    path.write_text(path.read_text().replace(poses.policy, "0" * len(poses.policy)))
    assert list(write_expert_poses(["Pusher"], tmp_path)) == [line]
