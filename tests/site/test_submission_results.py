"""Tints of the tables of returns."""

import pytest

from gym_extensions.scoring.group_score import ReferenceValue, TaskChange
from gym_extensions.scoring.scorecard import CoreGroup
from gym_extensions.site.pages.overview import Cell
from gym_extensions.site.submission_results import change_tint, tint


@pytest.mark.parametrize(
    ("ends", "classes"),
    [
        ((-0.6, -0.61, -0.59), "lost3"),
        ((-0.6,), "lost3 unsure"),
        ((0.79, 0.7, 0.9), "won4"),
        ((0.15, -2.4, 2.7), "won1 unsure"),
        ((0.0, 0.0, 0.0), "kept unsure"),
        ((-8.9, -9.0, -8.8), "lost5"),
    ],
)
def test_a_change_is_tinted_around_zero_and_hatched_where_it_is_uncertain(
    ends: tuple[float, ...], classes: str
) -> None:
    assert change_tint(TaskChange(*ends, normalized=True)) == classes


def test_a_raw_change_has_no_tint() -> None:
    assert change_tint(TaskChange(-30.0, normalized=False)) == "raw unsure"


def test_tints_of_a_matrix_reach_its_highest_score() -> None:
    reference = ReferenceValue(0.0, 100.0, False)
    assert [tint(value, reference, top=4.0) for value in (-50, 0, 100, 200, 400)] == [
        "below",
        "h0",
        "h3",
        "h5",
        "h10",
    ]


@pytest.mark.parametrize(("score", "tinted"), [(-0.2, "below"), (-0.03, "h0"), (0.25, "h3"), (1.2, "h10")])
def test_the_table_of_methods_has_the_same_tints(score: float, tinted: str) -> None:
    assert Cell(CoreGroup(score), "best").tint == tinted == tint(score, ReferenceValue(0.0, 1.0, False))
