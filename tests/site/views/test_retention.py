"""Retention: the change of each task's score since right after its training."""

from __future__ import annotations

import pytest

from gym_extensions.scoring.scorecard.model import GroupScore, ReferenceValue
from gym_extensions.site.charts.heatmap import change_tint, tint
from gym_extensions.site.views.retention import Retention

REFERENCE = {"a": ReferenceValue(0.0, 100.0, False), "b": ReferenceValue(0.0, None, True)}


def score(*runs: tuple[float, float]) -> GroupScore:
    """Two tasks; per run the return on the first right after its training and at the end."""
    return GroupScore(
        budget="smoke",
        runs=tuple(range(len(runs))),
        tasks=("a", "b"),
        metrics={},
        reference=REFERENCE,
        return_matrix=tuple(((0.0, 0.0), (after, 0.0), (end, 9.0)) for after, end in runs),
    )


def test_the_change_is_the_end_minus_right_after_training_over_the_span() -> None:
    (change,) = Retention(score((80, 50), (90, 60))).changes
    assert change.value.mean == pytest.approx(-0.3)
    assert change.value.ends == pytest.approx((-0.3, -0.3))
    assert change.normalized


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
    (change,) = Retention(score(*runs)).changes
    assert change_tint(change) == classes


def test_an_unsolved_task_has_a_raw_change() -> None:
    unsolved = {task: ReferenceValue(0.0, None, True) for task in ("a", "b")}
    whole = score((80, 50))
    (change,) = Retention(
        GroupScore(
            budget="smoke",
            runs=(0,),
            tasks=whole.tasks,
            metrics={},
            reference=unsolved,
            return_matrix=whole.return_matrix,
        )
    ).changes
    assert (change.value.mean, change.normalized, change_tint(change)) == (-30.0, False, "raw unsure")


def test_a_score_without_returns_has_no_changes() -> None:
    empty = GroupScore(budget="paper", runs=(), tasks=("a",), metrics={}, reference={}, return_matrix=())
    assert (Retention(empty).changes, Retention(empty).stages) == ((), ())


def test_tints_of_a_matrix_reach_its_highest_score() -> None:
    reference = ReferenceValue(0.0, 100.0, False)
    assert [tint(value, reference, top=4.0) for value in (-50, 0, 100, 200, 400)] == [
        "below",
        "h0",
        "h3",
        "h5",
        "h10",
    ]
