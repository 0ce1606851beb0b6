"""review.toml, and the level that follows from it."""

from pathlib import Path

import msgspec
import pytest

from gym_extensions.errors import BenchError
from gym_extensions.submissions import review as reviews

RUNS = {f"pusher/joint/run{run}": f"{run}" * 64 for run in range(3)}
SETTINGS = "5" * 64
PASSED = reviews.Verification(
    date="2026-11-26",
    version="1.0.0",
    value="ab" * 32,
    settings=SETTINGS,
    runs=RUNS,
    cells=9,
    p_value=0.5,
    passed=True,
)
FAILED = msgspec.structs.replace(PASSED, passed=False, p_value=1e-4, second_p_value=1e-5)
ACCEPTED = reviews.Decision(action="accepted", by="A", date="2026-11-26", reason="Ü\n")


@pytest.mark.parametrize(
    "review", [reviews.Review(), reviews.Review(verifications=[PASSED, FAILED], decisions=[ACCEPTED])]
)
def test_a_review_is_read_as_it_was_written(tmp_path: Path, review: reviews.Review) -> None:
    reviews.write_review(tmp_path, review)
    assert reviews.read_review(tmp_path) == review
    assert reviews.review_text(review) == (tmp_path / "review.toml").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("old", "new", "fact"),
    [
        ("passed = true", "passed = 1", "passed"),
        ("p_value = 0.5", "p_value = 1.5", "p_value"),
        ("passed =", "pased =", "pased"),
        ("pusher/joint/run0", "pusher/both/run0", "runs"),
        ('action = "accepted"', 'action = "praised"', "praised"),
        ("[[decisions]]", "[[decisions]", "line"),
    ],
)
def test_what_is_wrong_with_a_review_is_named(tmp_path: Path, old: str, new: str, fact: str) -> None:
    text = reviews.review_text(reviews.Review(verifications=[PASSED], decisions=[ACCEPTED]))
    assert old in text
    (tmp_path / "review.toml").write_text(text.replace(old, new), encoding="utf-8")
    with pytest.raises(BenchError, match=fact):
        reviews.read_review(tmp_path)


RETRAINED = msgspec.structs.replace(PASSED, retrained=["pusher/joint/run1"])
HALF = msgspec.structs.replace(PASSED, runs=dict(list(RUNS.items())[:2]))
REST = msgspec.structs.replace(PASSED, runs=dict(list(RUNS.items())[2:]))


@pytest.mark.parametrize(
    ("verifications", "expected"),
    [
        ([], reviews.CLAIMED),
        ([PASSED], reviews.VERIFIED),
        ([FAILED], reviews.CLAIMED),
        ([FAILED, PASSED], reviews.CLAIMED),
        ([PASSED, FAILED], reviews.CLAIMED),
        ([HALF], reviews.CLAIMED),
        ([HALF, REST], reviews.VERIFIED),
        ([RETRAINED], reviews.VERIFIED),
        ([msgspec.structs.replace(PASSED, settings="6" * 64)], reviews.CLAIMED),
        ([msgspec.structs.replace(FAILED, settings="6" * 64), PASSED], reviews.VERIFIED),
    ],
)
def test_a_log_is_verified_if_each_run_is_and_none_failed(
    verifications: list[reviews.Verification], expected: str
) -> None:
    assert reviews.level(reviews.Review(verifications=verifications), SETTINGS, RUNS) == expected


def test_a_run_that_changed_is_claimed_again_and_a_refusal_is_about_the_old_files() -> None:
    changed = RUNS | {"pusher/joint/run1": "f" * 64}
    assert reviews.level(reviews.Review(verifications=[PASSED]), SETTINGS, changed) == reviews.CLAIMED
    again = msgspec.structs.replace(PASSED, runs=changed)
    new = {"pusher/joint/run1": "f" * 64}
    review = reviews.Review(verifications=[FAILED, msgspec.structs.replace(again, runs=new)])
    assert reviews.level(review, SETTINGS, new) == reviews.VERIFIED
    assert reviews.level(review, SETTINGS, {}) == reviews.CLAIMED


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({}, {"pusher/joint/run1"}),
        ({"passed": False}, set()),
        ({"retrained": ["pusher/joint/run9"]}, set()),
        ({"runs": RUNS | {"pusher/joint/run1": "f" * 64}}, set()),
    ],
)
def test_a_run_that_was_trained_again_as_it_is_now_is_reproduced(
    changes: dict[str, object], expected: set[str]
) -> None:
    changed = msgspec.structs.replace(RETRAINED, **changes)
    assert reviews.reproduced(reviews.Review(verifications=[changed]), SETTINGS, RUNS) == expected
