"""Boards: order, rank intervals, who has no rank, and that scores on it are the scorecards'."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from gym_extensions.catalog.suites import SUITES
from gym_extensions.scoring.leaderboard.board import board, boards
from gym_extensions.scoring.leaderboard.keys import BoardKey, board_keys, slim
from gym_extensions.scoring.pipeline import batch
from gym_extensions.scoring.pipeline.score import score_folders, text
from gym_extensions.scoring.references import References
from gym_extensions.scoring.scorecard.suites import suite_scores

FIVE = (0, 1, 2, 3, 4)
GROUP = "hopper-gravity-v0"
KEY = BoardKey(GROUP, "sequential", "100k", False)

Enter = Callable[..., dict[str, Any]]


@pytest.fixture
def enter(submission: Callable[..., Path], references: References, manifest_text: str) -> Enter:
    """The scorecard of an entry whose returns lie around a level, as ``enter(name, level, …)``."""

    def make(name: str, level: float, runs: tuple[int, ...] = FIVE, told: bool = False, **more: Any) -> Any:
        manifest = manifest_text.replace('"smoke"', '"100k"')
        if told:
            manifest = manifest.replace("task_in_evaluation = false", "task_in_evaluation = true")
        more.setdefault(
            "value", lambda p, run, stage, j, e: stage * level / 5 + 10.0 * (run * 3 % 5) + j - e / 20
        )
        more.setdefault("protocols", ("sequential",))
        folder = submission(name=name, runs=runs, manifest=manifest, **more)
        return score_folders([folder], references)["submissions"][0]

    return make


def names(found: dict[str, Any]) -> list[str]:
    return [row["name"] for row in found["rows"]]


def test_entries_are_sorted_by_final_performance_and_ranked_by_intervals(enter: Enter) -> None:
    found = board([enter("low", 200), enter("high", 900), enter("tied", 901)], KEY)
    assert names(found) == ["tied", "high", "low"]
    assert [row["metrics"]["final_performance"]["rank"] for row in found["rows"]] == [[1, 2], [1, 2], [3, 3]]
    assert found["ranked"] == 3
    tied, high, low = found["rows"]
    assert (tied["next"]["name"], tied["next"]["separated"]) == ("high", False)
    assert tied["next"]["more_runs"] is None  # more than 100
    assert (high["next"]["separated"], high["next"]["more_runs"]) == (True, 0)
    assert "next" not in low


def on_gravity(card: dict[str, Any], mean: float) -> dict[str, Any]:
    """The scorecard with every group of the suite: five runs of each, with that mean and the deviation 1."""
    groups = {}
    for name in SUITES["gravity"]:
        metrics = {
            "final_performance": {
                "runs": [mean + step / math.sqrt(2.5) for step in range(-2, 3)],
                "mean": mean,
            }
        }
        scored = card["groups"][GROUP]["sequential"]
        groups[name] = {"sequential": scored | {"metrics": scored["metrics"] | metrics}}
    return card | {"groups": groups, "suites": suite_scores(groups)}


@pytest.mark.parametrize(("where", "gap", "more"), [(GROUP, 1.25, 7), ("gravity", 0.625, 6)])
def test_the_runs_that_would_separate_two_are_those_of_every_group(
    enter: Enter, where: str, gap: float, more: int
) -> None:
    # One and a quarter deviations apart on both: the suite's is half a group's. See test_ranks.
    cards = [on_gravity(enter("high", 900), gap), on_gravity(enter("low", 200), 0.0)]
    (high, _) = board(cards, BoardKey(where, "sequential", "100k", False))["rows"]
    assert (high["next"]["name"], high["next"]["separated"], high["next"]["more_runs"]) == (
        "low",
        False,
        more,
    )


def test_entries_with_fewer_runs_stand_below_without_a_rank_and_count_nowhere(enter: Enter) -> None:
    found = board([enter("few", 950, runs=(0, 1)), enter("low", 200), enter("high", 900)], KEY)
    assert names(found) == ["high", "low", "few"]
    assert [row["metrics"]["final_performance"]["rank"] for row in found["rows"]] == [[1, 1], [2, 2], None]
    assert found["rows"][2]["why"] == "Fewer than 5 runs."


def test_scores_on_a_board_are_the_scorecards_and_do_not_move_when_somebody_joins(enter: Enter) -> None:
    first, second, third = enter("a", 300), enter("b", 600), enter("c", 610)
    before, after = board([first, second], KEY), board([third, first, second], KEY)
    scores = {
        found["name"]: {
            name: {key: value for key, value in score.items() if key != "rank"}
            for name, score in found["metrics"].items()
        }
        for found in before["rows"]
    }
    for row in after["rows"]:
        for name, score in row["metrics"].items():
            if row["name"] in scores:
                expected = scores[row["name"]][name]
                assert {key: value for key, value in score.items() if key != "rank"} == expected
    final = first["groups"][GROUP]["sequential"]["metrics"]["final_performance"]
    assert scores["a"]["final_performance"]["mean"] == final["mean"]
    assert after["rows"][0]["metrics"]["final_performance"]["rank"] == [1, 2]


def test_who_learned_nothing_has_no_rank_for_forgetting(enter: Enter) -> None:
    idle = enter("idle", 0, value=lambda p, run, stage, j, e: float((run * 7 + stage * 3 + j + e) % 11) - 5)
    found = board([idle, enter("learner", 900)], KEY)
    learner, zero = found["rows"]
    assert zero["metrics"]["forgetting"]["instead"] == "nothing learned to forget"
    assert zero["metrics"]["forgetting"]["rank"] is None
    assert learner["metrics"]["forgetting"]["rank"] == [1, 1]
    assert "instead" not in learner["metrics"]["forgetting"]


def test_the_joint_gap_is_ranked_where_five_joint_runs_stand_behind_it(enter: Enter) -> None:
    both = ("sequential", "joint")
    cards = [enter("low", 200, protocols=both), enter("high", 900, protocols=both), enter("without", 500)]
    few = enter("few", 400, protocols=both)
    for score in few["groups"][GROUP]["joint"]["metrics"].values():
        score["runs"] = score["runs"][:4]
    ranks = {row["name"]: row["metrics"]["joint_gap"]["rank"] for row in board([*cards, few], KEY)["rows"]}
    # Joint returns are a fifth of the sequential ones: the gap is −.8 level, and lower is better.
    assert ranks == {"high": [1, 1], "low": [2, 2], "without": None, "few": None}


def test_agents_that_are_told_the_task_have_a_board_of_their_own(enter: Enter) -> None:
    cards = [enter("told", 900, told=True), enter("free", 100)]
    assert [(key.told, names(board(cards, key))) for key in board_keys(cards)] == [
        (False, ["free"]),
        (True, ["told"]),
    ]


def test_the_smoke_budget_is_on_no_board(submission: Callable[..., Path], references: References) -> None:
    cards = score_folders([submission(runs=FIVE)], references)["submissions"]
    assert boards(cards) == []
    assert batch.boards_text(cards) == text({"format": 1, "boards": []})


def test_a_reported_entry_stands_on_a_board_without_a_rank() -> None:
    (card,) = score_folders([Path(__file__).parents[3] / "submissions" / "henderson2017-trpo"])["submissions"]
    found = board([card], BoardKey("hopper-gravity-v0", "sequential", "paper", False))
    assert (found["ranked"], found["rows"][0]["why"]) == (0, "Reported from a publication: no logs.")
    assert found["rows"][0]["metrics"]["final_performance"]["mean"] is None


def test_an_entry_that_repeats_another_is_told(enter: Enter) -> None:
    cards = [enter("original", 500), enter("copied", 500), enter("other", 501), enter("again", 500)]
    found = board(cards, KEY)
    assert {row["name"]: row.get("same_as") for row in found["rows"]} == {
        "again": "copied",
        "copied": "again",
        "original": "again",
        "other": None,
    }


def test_boards_made_side_by_side_are_the_same(enter: Enter, monkeypatch: pytest.MonkeyPatch) -> None:
    cards = [slim(enter(f"entry{number}", 100 * number, told=number > 2)) for number in range(1, 5)]
    monkeypatch.setattr(batch, "MANY_ENTRIES", 4)
    alone = text({"format": 1, "boards": boards(cards)})
    assert batch.boards_text(cards, 2) == batch.boards_text(cards, 1) == alone
    assert len(boards(cards)) > 1


def test_a_slim_scorecard_gives_the_same_boards(enter: Enter) -> None:
    cards = [enter("a", 300), enter("b", 600), enter("c", 610, runs=(0,))]
    assert boards([slim(card) for card in cards]) == boards(cards)


def test_a_board_does_not_depend_on_the_order_of_its_entries(enter: Enter) -> None:
    cards = [enter(f"e{level}", level) for level in (100, 500, 505, 900)]
    assert boards(cards) == boards(cards[::-1])
