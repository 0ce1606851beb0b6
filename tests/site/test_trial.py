"""The scores of one submission, what it retains, and the worked example."""

from __future__ import annotations

from dataclasses import replace

import pytest

from gym_extensions.scoring.scorecard import GroupScore, ReferenceValue
from gym_extensions.site.tables import change_tint, tint
from gym_extensions.site.trial import EXAMPLE, Retention, Trial

SCORE = GroupScore(
    level="verified",
    budget="smoke",
    runs=(0, 1),
    tasks=("a", "b"),
    metrics={},
    reference={},
    return_matrix=(),
)


def test_success_rates_are_averaged_over_runs_where_the_task_defines_success() -> None:
    rates = (((None, 0.25), (None, 0.5)), ((None, 0.75), (None, 1.0)))
    trial = Trial("group", "sequential", replace(SCORE, success_rates=rates))
    assert trial.success_rates == ((None, 0.5), (None, 0.75))


REFERENCE = {"a": ReferenceValue(0.0, 100.0, False), "b": ReferenceValue(0.0, None, True)}


def score(*runs: tuple[float, float]) -> GroupScore:
    """Two tasks; per run the return on the first right after its training and at the end."""
    return GroupScore(
        level="verified",
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


def test_an_open_task_has_a_raw_change() -> None:
    open_tasks = {task: ReferenceValue(0.0, None, True) for task in ("a", "b")}
    whole = score((80, 50))
    (change,) = Retention(
        GroupScore(
            level="verified",
            budget="smoke",
            runs=(0,),
            tasks=whole.tasks,
            metrics={},
            reference=open_tasks,
            return_matrix=whole.return_matrix,
        )
    ).changes
    assert (change.value.mean, change.normalized, change_tint(change)) == (-30.0, False, "raw unsure")


def test_tints_of_a_matrix_reach_its_highest_score() -> None:
    reference = ReferenceValue(0.0, 100.0, False)
    assert [tint(value, reference, top=4.0) for value in (-50, 0, 100, 200, 400)] == [
        "below",
        "h0",
        "h3",
        "h5",
        "h10",
    ]


def test_values_by_hand() -> None:
    values = EXAMPLE.values
    by_hand = {
        "final_performance": 0.7,
        "learning_performance": 0.9,
        "forgetting": 0.3,
        "worst_case_forgetting": 0.3,
        "mean_later_forgetting": ((0.3 + 0.4) / 2 + 0.2) / 2,
        "asymptotic_transfer": 0.1,
        "zero_shot_transfer": (0.1 + 0.3) / 2,
        "generalization_to_unseen_tasks": (0.1 + 0.1 + 0.3) / 3,
        "forward_transfer_auc": 0.2,
        "joint_gap": 0.2,
        "cvar_10": 0.7 - 0.18,
        "single_task_performance": 2.5 / 3,
    }
    assert {name: values[name] for name in by_hand} == pytest.approx(by_hand)
