"""Boards: who is compared with whom, in what order, and what may be said of the first."""

from __future__ import annotations

from typing import Any

import pytest

from gym_extensions.site.boards import COLUMNS, Board, boards
from gym_extensions.site.document import Entry, Estimate, Trial
from gym_extensions.site.page import Leaderboard

LEARNED = Estimate(0.8, 0.7, 0.9, (0.7, 0.9))


def entry(name: str, final: Estimate, learning: Estimate = LEARNED, runs: int = 5, **facts: Any) -> Entry:
    """An entry with one sequential trial on hopper-gravity at the budget 100k."""
    metrics = {"final_performance": final, "learning_performance": learning}
    budget = facts.pop("budget", "100k")
    trial = Trial(
        group="hopper-gravity-v0",
        protocol="sequential",
        budget=budget,
        runs=tuple(range(runs)),
        tasks=(),
        metrics=metrics,
        table=(),
        total={},
        references={},
        matrix=(),
        returns=(),
        curves=(),
    )
    return Entry(name, name.title(), "well-formed", manifest=facts, trials=(trial,))


def estimate(mean: float, half: float = 0.05) -> Estimate:
    """An estimate with an interval of that half width."""
    return Estimate(mean, mean - half, mean + half, (mean - half, mean + half))


def only(*entries: Entry) -> Board:
    """The one board of these entries."""
    (board,) = boards(entries)
    return board


def names(board: Board) -> list[str]:
    """Its entries from top to bottom."""
    return [row.entry.name for row in board.rows]


def test_a_board_is_sorted_by_final_performance_then_name() -> None:
    board = only(entry("b", estimate(0.3)), entry("c", estimate(0.9)), entry("a", estimate(0.3)))
    assert names(board) == ["c", "a", "b"]


def test_an_entry_without_a_value_stands_last_and_not_at_zero() -> None:
    board = only(entry("open", Estimate(why="all open")), entry("worse", estimate(-0.5)))
    assert names(board) == ["worse", "open"]


def test_entries_with_fewer_than_five_runs_stand_below_under_a_heading() -> None:
    board = only(entry("lucky", estimate(0.9), runs=4), entry("full", estimate(0.4)))
    assert [(heading, [row.entry.name for row in rows]) for heading, rows in board.bodies] == [
        ("", ["full"]),
        ("Fewer than 5 runs: shown, not ranked", ["lucky"]),
    ]


def test_forgetting_stands_right_beside_learning_performance() -> None:
    columns = COLUMNS["sequential"]
    assert columns.index("forgetting") == columns.index("learning_performance") + 1


def test_entries_told_the_task_have_a_board_of_their_own() -> None:
    plain, told = boards(
        [entry("a", estimate(0.5)), entry("b", estimate(0.9), knows={"task_in_evaluation": True})]
    )
    assert (names(plain), plain.told) == (["a"], False)
    assert (names(told), told.told, told.id) == (["b"], True, "hopper-gravity-v0-sequential-100k-told")


def test_being_told_the_task_while_training_alone_is_no_other_board() -> None:
    board = only(entry("a", estimate(0.5), knows={"task_in_training": True, "task_in_evaluation": False}))
    assert not board.told


def test_budgets_are_never_compared_and_smoke_is_on_no_board() -> None:
    found = boards([entry(name, estimate(0.5), budget=name) for name in ("smoke", "100k", "1M", "paper")])
    assert [(board.budget, names(board)) for board in found] == [
        ("paper", ["paper"]),
        ("1M", ["1M"]),
        ("100k", ["100k"]),
    ]


def test_a_refused_submission_is_on_no_board(document: dict[str, Any]) -> None:
    broken = document["submissions"][-1]
    broken["groups"] = document["submissions"][0]["groups"]
    assert "broken" not in {row.entry.name for board in Leaderboard(document).boards for row in board.rows}


@pytest.mark.parametrize(
    ("entries", "sentence"),
    [
        ([entry("a", estimate(0.9))], "It is the only full entry."),
        ([entry("a", estimate(0.9), runs=2)], "It is the only entry with a value."),
        (
            [entry("a", estimate(0.9)), entry("b", estimate(0.7))],
            "Its interval lies above that of every other entry.",
        ),
        (
            [entry("a", estimate(0.9)), entry("b", estimate(0.85)), entry("c", estimate(0.82))],
            "Its interval does not lie clear of B and C, so the order may be chance.",
        ),
        (
            [entry("a", estimate(0.9)), *(entry(name, estimate(0.88)) for name in "bcde")],
            "Its interval does not lie clear of 4 others, so the order may be chance.",
        ),
        (
            [entry("a", Estimate(0.9, None, None, (0.9,)), runs=1), entry("b", estimate(0.1), runs=2)],
            "It has one run, so nothing can be said about how sure that is.",
        ),
        (
            [entry("a", estimate(0.9), runs=2), entry("b", Estimate(0.1, None, None, (0.1,)), runs=1)],
            "Its interval does not lie clear of B, so the order may be chance.",
        ),
    ],
)
def test_a_lead_is_never_surer_than_its_interval(entries: list[Entry], sentence: str) -> None:
    lead = only(*entries).lead()
    assert lead is not None
    assert (lead[0].entry.name, lead[1]) == ("a", sentence)


def test_a_full_entry_leads_before_a_better_one_with_fewer_runs() -> None:
    lead = only(entry("lucky", estimate(0.9), runs=1), entry("full", estimate(0.4))).lead()
    assert lead is not None
    assert lead[0].entry.name == "full"


def test_nobody_leads_where_nobody_has_a_value() -> None:
    assert only(entry("a", Estimate(why="all open"))).lead() is None


@pytest.mark.parametrize(
    ("learning", "nothing"),
    [
        (Estimate(0.5, 0.1, 0.9, (0.4, 0.6)), False),
        (Estimate(0.5, 0.0, 1.0, (0.4, 0.6)), True),
        (Estimate(0.05, 0.01, 0.09, (0.04, 0.06)), False),
        (Estimate(0.0999, None, None, (0.0999,)), True),
        (Estimate(0.1, None, None, (0.1,)), False),
        (Estimate(why="all open"), False),
    ],
)
def test_who_learned_nothing_has_nothing_to_forget(learning: Estimate, nothing: bool) -> None:
    assert only(entry("a", estimate(0.5), learning)).rows[0].trial.learned_nothing is nothing
