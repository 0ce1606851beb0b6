"""The order of a board and the ranks on it: by intervals, of five runs or more, and none with its reason."""

from __future__ import annotations

from dataclasses import replace

import pytest

from gym_extensions.scoring.leaderboard.board import board
from gym_extensions.scoring.leaderboard.keys import BoardKey
from gym_extensions.scoring.leaderboard.model import BoardEntry, VersusNext
from gym_extensions.scoring.metrics.value import MetricValue
from gym_extensions.scoring.scorecard.model import Scorecard

from .entries import GROUP, KEY, Enter, final_ranks, names, on_gravity


def versus_next(entry: BoardEntry) -> VersusNext:
    assert entry.vs_next is not None
    return entry.vs_next


def test_entries_are_sorted_by_final_performance_and_ranked_by_intervals(enter: Enter) -> None:
    made = board([enter("low", 200), enter("high", 900), enter("tied", 901)], KEY)
    assert names(made) == ["tied", "high", "low"]
    assert final_ranks(made) == [(1, 2), (1, 2), (3, 3)]
    assert made.ranked == 3
    tied, high, low = made.rows
    assert (versus_next(tied).name, versus_next(tied).separated) == ("high", False)
    assert versus_next(tied).more_runs is None  # more than 100
    assert (versus_next(high).separated, versus_next(high).more_runs) == (True, 0)
    assert low.vs_next is None
    assert [entry.why for entry in made.rows] == ["", "", ""]
    assert [entry.runs for entry in made.rows] == [5, 5, 5]


@pytest.mark.parametrize(("where", "gap", "more"), [(GROUP, 1.25, 7), ("gravity", 0.625, 6)])
def test_the_runs_that_would_separate_two_are_those_of_every_group(
    enter: Enter, where: str, gap: float, more: int
) -> None:
    # One and a quarter deviations apart on both: the suite's is half a group's. See test_ranking.
    cards = [on_gravity(enter("high", 900), gap), on_gravity(enter("low", 200), 0.0)]
    high, _ = board(cards, BoardKey(where, "sequential", "100k", False)).rows
    versus = versus_next(high)
    assert (versus.name, versus.separated, versus.more_runs) == ("low", False, more)


def test_entries_with_fewer_runs_are_below_without_a_rank_and_count_nowhere(enter: Enter) -> None:
    made = board([enter("few", 950, runs=(0, 1)), enter("low", 200), enter("high", 900)], KEY)
    assert names(made) == ["high", "low", "few"]
    assert final_ranks(made) == [(1, 1), (2, 2), None]
    assert made.rows[2].why == "Fewer than 5 runs."


def test_an_entry_that_learned_nothing_has_no_rank_for_forgetting(enter: Enter) -> None:
    idle = enter("idle", 0, value=lambda p, run, stage, j, e: float((run * 7 + stage * 3 + j + e) % 11) - 5)
    learner, still = board([idle, enter("learner", 900)], KEY).rows
    assert still.metrics["forgetting"].rank_note == "nothing learned to forget"
    assert still.metrics["forgetting"].rank is None
    assert learner.metrics["forgetting"].rank == (1, 1)
    assert learner.metrics["forgetting"].rank_note == ""


def test_the_joint_gap_is_ranked_with_five_joint_runs(enter: Enter) -> None:
    both = ("sequential", "joint")
    cards = [enter("low", 200, protocols=both), enter("high", 900, protocols=both), enter("without", 500)]
    few = enter("few", 400, protocols=both)
    joint = few.groups[GROUP]["joint"]
    four = {name: replace(value, runs=value.runs[:4]) for name, value in joint.metrics.items()}
    protocols = {**few.groups[GROUP], "joint": replace(joint, metrics=four)}
    made = board([*cards, replace(few, groups={GROUP: protocols})], KEY)
    ranks = {entry.name: entry.metrics["joint_gap"].rank for entry in made.rows}
    # Joint returns are a fifth of the sequential ones: the gap is −.8 level, and lower is better.
    assert ranks == {"high": (1, 1), "low": (2, 2), "without": None, "few": None}


def test_each_ranked_entry_is_compared_with_the_first_over_m_minus_1_tests(enter: Enter) -> None:
    first, near, far = board([enter("a", 900), enter("b", 899), enter("c", 100)], KEY).rows
    assert first.vs_leader is None
    assert near.vs_leader is not None
    assert far.vs_leader is not None
    assert (near.vs_leader.name, near.vs_leader.separated) == ("a", False)
    assert (far.vs_leader.name, far.vs_leader.separated) == ("a", True)
    a, c = (entry.metrics["final_performance"].mean for entry in (first, far))
    assert a is not None
    assert c is not None
    assert far.vs_leader.difference.mean == pytest.approx(a - c)


def with_metrics(card: Scorecard, **values: MetricValue) -> Scorecard:
    """The scorecard with other values of some sequential metrics on ``GROUP``."""
    score = card.groups[GROUP]["sequential"]
    changed = replace(score, metrics={**score.metrics, **values})
    return replace(card, groups={GROUP: {"sequential": changed}})


def test_final_performance_sorts_a_board_whatever_the_other_metrics_are(enter: Enter) -> None:
    def shifted(name: str, final: float, learning: float) -> Scorecard:
        return with_metrics(
            enter(name, 300),
            final_performance=MetricValue(mean=final, runs=(final,) * 5),
            learning_performance=MetricValue(mean=learning, runs=(learning,) * 5),
        )

    made = board([shifted("learns", 0.2, 0.9), shifted("ends", 0.8, 0.1)], KEY)
    assert names(made) == ["ends", "learns"]


def test_an_entry_without_final_performance_has_its_reason_and_no_rank(enter: Enter) -> None:
    card = with_metrics(enter("a", 300), final_performance=MetricValue(why="Every task is unsolved."))
    (entry,) = board([card], KEY).rows
    assert (entry.ranked, entry.why) == (False, "Every task is unsolved.")
    assert entry.metrics["learning_performance"].mean is not None
