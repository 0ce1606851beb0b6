"""What a trial shows of its scorecard."""

from __future__ import annotations

from dataclasses import replace

from gym_extensions.scoring.scorecard.model import GroupScore
from gym_extensions.site.views.trial import Trial

SCORE = GroupScore(budget="smoke", runs=(0, 1), tasks=("a", "b"), metrics={}, reference={}, return_matrix=())


def test_success_rates_are_averaged_over_runs_where_the_task_defines_success() -> None:
    rates = (((None, 0.25), (None, 0.5)), ((None, 0.75), (None, 1.0)))
    trial = Trial("group", "sequential", replace(SCORE, success_rates=rates))
    assert trial.success_rates == ((None, 0.5), (None, 0.75))


def test_a_group_without_success_has_no_table_of_success_rates() -> None:
    assert Trial("group", "sequential", SCORE).success_rates == ()
