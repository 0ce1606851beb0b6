"""When a policy is a record, and which paths mean records."""

from __future__ import annotations

from pathlib import Path

import pytest

from gym_extensions.catalog.tasks import task
from gym_extensions.errors import BenchError
from gym_extensions.references import experts, load_references
from gym_extensions.references.experts import Measurement, RecordCard
from gym_extensions.scoring.records import Bar, RecordReview, bar, problem_of, read_record_review, split_paths
from gym_extensions.submissions.poses import PolicyPoses

CLAIM = Measurement(episodes=100, mean=100.0, deviation=5.0)
CARD = RecordCard("gym_extensions/Hopper-v0", "", "", (), CLAIM, ("A",))
EXPERT = Bar(90.0, standard_error=1.0)


def test_a_record_lies_three_standard_errors_of_the_difference_above_the_expert() -> None:
    least = 90.0 + 3 * (1 + 0.5**2) ** 0.5
    assert EXPERT.least(0.5) == pytest.approx(least)
    assert problem_of(CARD, EXPERT, Measurement(100, 100.0, 5.0)) == ""
    assert "to beat the expert, 99.0" in problem_of(CARD, Bar(99.0, 1.0), Measurement(100, 100.0, 5.0))


def test_on_an_open_task_a_record_beats_the_floor_by_the_rule_for_anchors() -> None:
    assert Bar(50.0, floor_deviation=10.0).least(standard_error=1.0) == 70.0
    assert Bar(50.0, floor_deviation=1.0).least(standard_error=1.0) == 55.0


def test_a_record_that_falls_short_of_its_claim_is_none_even_above_the_expert() -> None:
    """2.65 standard errors of the difference of 5 √(2/100) are 1.87."""
    assert problem_of(CARD, EXPERT, Measurement(100, 98.2, 5.0)) == ""
    assert "the card claims 100.0" in problem_of(CARD, EXPERT, Measurement(100, 98.0, 5.0))


def test_a_large_claimed_deviation_does_not_widen_the_margin() -> None:
    claim = Measurement(episodes=100, mean=100.0, deviation=1e6)
    card = RecordCard(CARD.task, "", "", (), claim, ("A",))
    assert problem_of(card, EXPERT, Measurement(100, 98.0, 5.0)) != ""


def test_the_bar_is_the_anchor_or_the_floor_of_an_open_task() -> None:
    hopper, striker = bar(task("Hopper")), bar(task("Striker"))
    assert (hopper.mean, hopper.floor_deviation) == (load_references().tasks[task("Hopper").id].expert, None)
    assert striker.floor_deviation is not None


def test_records_are_told_from_submissions_by_their_folder(tmp_path: Path) -> None:
    folder = tmp_path / "records"
    (folder / "Hopper").mkdir(parents=True)
    for name in ("a", "b"):
        (folder / "Hopper" / f"{name}.npz").touch()
    names = {
        "records": ["Hopper/a", "Hopper/b"],
        "records/Hopper": ["Hopper/a", "Hopper/b"],
        "records/Hopper/a": ["Hopper/a"],
        "records/Hopper/b.npz": ["Hopper/b"],
        "records/Hopper/new.json": ["Hopper/new"],
        "records/submissions": [],
        "submissions/Hopper": [],
    }
    for path, expected in names.items():
        found, others = split_paths([tmp_path / path])
        assert [record.name for record in found] == expected
        assert bool(others) == (not expected)


def test_a_review_is_read_only_as_it_is_written(tmp_path: Path) -> None:
    numbers = {"episodes": 100, "mean": 1.0, "deviation": 1.0, "least": 0.0}
    texts = {"date": "2026-01-01", "version": "1", "value": "3f" * 20, "problem": ""}
    review = RecordReview(card="0" * 64, poses=None, **numbers, **texts)  # type: ignore[arg-type]
    path = tmp_path / "a.review.json"
    path.write_text(review.to_json())
    assert read_record_review(path) == review
    for text in ("", "{}", review.to_json() + " ", review.to_json().replace("1.0", "1e999")):
        path.write_text(text)
        with pytest.raises(BenchError) as error:
            read_record_review(path)
        assert error.value.code == "bad-review"


def test_experts_are_shown_with_poses_of_their_present_policy() -> None:
    files = sorted((experts.DATA / "poses").iterdir())
    assert [path.stem for path in files] == experts.names()
    assert sum(path.stat().st_size for path in files) < 600_000
    for path in files:
        poses = PolicyPoses.load(path, "", "")
        assert poses is not None
        assert poses.policy == experts.card(path.stem).policy
        assert poses.poses.after.coordinates(poses.poses.unit).shape[0] == poses.poses.after.frames
