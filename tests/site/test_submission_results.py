"""The results of a submission on a group, and what it retains."""

from __future__ import annotations

from dataclasses import replace

import pytest

from gym_extensions.scoring.scorecard import GroupScore, ReferenceValue
from gym_extensions.site.submission_results import SubmissionResult
from gym_extensions.site.tables import change_tint

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
    result = SubmissionResult("group", "sequential", replace(SCORE, success_rates=rates))
    assert result.success_rates == ((None, 0.5), (None, 0.75))


REFERENCE = {"a": ReferenceValue(0.0, 100.0, False), "b": ReferenceValue(0.0, None, True)}


def score(*runs: tuple[float, float]) -> GroupScore:
    """Two tasks; per run the return on the first right after its training and at the end."""
    return replace(
        SCORE,
        runs=tuple(range(len(runs))),
        reference=REFERENCE,
        return_matrix=tuple(((0.0, 0.0), (after, 0.0), (end, 9.0)) for after, end in runs),
    )


def test_the_change_is_the_end_minus_right_after_training_over_the_span() -> None:
    (change,) = SubmissionResult("group", "sequential", score((80, 50), (90, 60))).changes
    assert change.value.mean == pytest.approx(-0.3)
    assert change.value.ends == pytest.approx((-0.3, -0.3))
    assert change.normalized


def test_an_open_task_has_a_raw_change() -> None:
    open_tasks = {task: ReferenceValue(0.0, None, True) for task in ("a", "b")}
    result = SubmissionResult("group", "sequential", replace(score((80, 50)), reference=open_tasks))
    (change,) = result.changes
    assert (change.value.mean, change.normalized, change_tint(change)) == (-30.0, False, "raw unsure")
