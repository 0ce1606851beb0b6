"""The frames of scorecards, and that --csv has their numbers."""

import io

import pandas as pd
import pytest

from gym_extensions.scoring.output.board_frames import METRIC_DTYPES, metrics_frame, to_csv, typed
from gym_extensions.scoring.pipeline import score_folders
from gym_extensions.scoring.scorecard import ScorecardDocument

from ...conftest import GRAVITY, Write


@pytest.fixture
def document(make_submission: Write, known: None) -> ScorecardDocument:
    """A submission with a suite, and a submission with two problems."""
    make_submission(name="good", groups=GRAVITY, runs=(0, 1, 2))
    bad = make_submission(name="bad")
    for name in ("a", "b"):
        (bad / f"{name}.txt").write_text("")
    return score_folders([bad.parent])


def test_the_csv_read_back_is_the_frame(document: ScorecardDocument) -> None:
    frame = metrics_frame(document.submissions)
    dtypes = {name: dtype for name, dtype in METRIC_DTYPES.items() if dtype != "float64"}
    read = pd.read_csv(io.StringIO(to_csv(frame)), dtype=dtypes, float_precision="round_trip")
    read = read.fillna({"why": ""})
    pd.testing.assert_frame_equal(read, frame, check_exact=True)


def test_a_text_that_begins_like_a_formula_is_quoted_in_the_csv_alone() -> None:
    frame = typed([("=1+1", -1.0), ("b=-1", 2.0)], {"name": "str", "mean": "float64"})
    assert to_csv(frame) == "name,mean\n'=1+1,-1.0\nb=-1,2.0\n"
    assert frame["name"].tolist() == ["=1+1", "b=-1"]


def test_a_problem_is_a_row_with_a_name_and_a_reason(document: ScorecardDocument) -> None:
    problems = metrics_frame(document.submissions).query("name == 'bad'")
    told = [f"unexpected-name: {name}.txt: Unexpected file." for name in "ab"]
    assert problems["why"].tolist() == told
    assert problems.drop(columns=["name", "why"]).isna().all(axis=None)
