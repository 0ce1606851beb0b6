"""Tints of the tables of returns."""

from __future__ import annotations

import pytest

from gym_extensions.scoring.scorecard import ReferenceValue
from gym_extensions.site.submission_results import SubmissionResult
from gym_extensions.site.tables import change_tint, tint

from .test_submission_results import score


@pytest.mark.parametrize(
    ("runs", "classes"),
    [
        ([(80, 20), (80, 20.1)], "lost3"),
        ([(80, 20)], "lost3 unsure"),
        ([(20, 99), (20, 99.1)], "won4"),
        ([(10, 0), (10, 50)], "won1 unsure"),
        ([(50, 50), (50, 50)], "kept unsure"),
        ([(900, 0), (900, 1)], "lost5"),
    ],
)
def test_a_change_is_tinted_around_zero_and_hatched_where_it_is_uncertain(
    runs: list[tuple[float, float]], classes: str
) -> None:
    (change,) = SubmissionResult("group", "sequential", score(*runs)).changes
    assert change_tint(change) == classes


def test_tints_of_a_matrix_reach_its_highest_score() -> None:
    reference = ReferenceValue(0.0, 100.0, False)
    assert [tint(value, reference, top=4.0) for value in (-50, 0, 100, 200, 400)] == [
        "below",
        "h0",
        "h3",
        "h5",
        "h10",
    ]
