"""Boards: which entries are on which board, and scores equal to those of the scorecards."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import permutations
from pathlib import Path

from gym_extensions.scoring.leaderboard.board import board, boards
from gym_extensions.scoring.leaderboard.keys import BoardKey, board_keys, strip_for_boards
from gym_extensions.scoring.leaderboard.model import Board, BoardsDocument
from gym_extensions.scoring.pipeline.score import score_folder
from gym_extensions.scoring.references import References

from .entries import FIVE, GROUP, KEY, Enter, final_ranks, names, on_gravity


def test_scores_are_those_of_the_scorecards_and_do_not_move_when_an_entry_joins(enter: Enter) -> None:
    first, second, third = enter("a", 300), enter("b", 600), enter("c", 613)

    def scores(made: Board) -> dict[str, dict[str, tuple[float | None, ...]]]:
        return {
            entry.name: {name: (value.mean, value.low, value.high) for name, value in entry.metrics.items()}
            for entry in made.rows
        }

    before, after = board([first, second], KEY), board([third, first, second], KEY)
    assert {name: scores(after)[name] for name in "ab"} == scores(before)
    assert scores(before)["a"] == {
        name: (value.mean, value.low, value.high)
        for name, value in first.groups[GROUP]["sequential"].metrics.items()
    }
    assert (final_ranks(before), final_ranks(after)) == ([(1, 1), (2, 2)], [(1, 2), (1, 2), (3, 3)])


def test_agents_that_observe_the_task_have_a_board_of_their_own(enter: Enter) -> None:
    cards = [enter("conditioned", 900, task_conditioned=True), enter("plain", 100)]
    assert [(key.task_conditioned, names(board(cards, key))) for key in board_keys(cards)] == [
        (False, ["plain"]),
        (True, ["conditioned"]),
    ]


def test_the_smoke_budget_is_on_no_board(submission: Callable[..., Path], references: References) -> None:
    assert boards([score_folder(submission(runs=FIVE), references)]) == BoardsDocument(boards=())
    assert BoardsDocument(boards=()).format == 1


def test_a_reported_entry_is_on_a_board_without_a_rank() -> None:
    card = score_folder(Path(__file__).parents[3] / "submissions" / "henderson2017-trpo")
    made = board([card], BoardKey("hopper-gravity-v0", "sequential", "paper", False))
    assert (made.ranked, made.rows[0].why) == (0, "Reported from a publication: no logs.")
    assert made.rows[0].metrics["final_performance"].mean is None


def test_a_stripped_scorecard_gives_the_same_boards(enter: Enter) -> None:
    cards = [enter("a", 300), enter("b", 600), enter("c", 610, runs=(0,))]
    stripped = [strip_for_boards(card) for card in cards]
    assert boards(stripped) == boards(cards)
    assert stripped[0].groups[GROUP]["sequential"].return_matrix == ()


def test_the_order_of_the_entries_does_not_matter(enter: Enter) -> None:
    """In any order, ties in final performance included, which the name decides."""
    cards = [enter("b", 500), enter("a", 500), enter("high", 900), enter("few", 500, runs=(0, 1))]
    made = [boards(order) for order in permutations(cards)]
    assert names(made[0].boards[0]) == ["high", "a", "b", "few"]
    assert all(other == made[0] for other in made)


def test_an_entry_on_a_suite_has_the_fewest_runs_of_its_groups(enter: Enter) -> None:
    card = on_gravity(enter("a", 300), 0.5)
    few = replace(card.groups[GROUP]["sequential"], runs=(0, 1, 2))
    card = replace(card, groups={**card.groups, GROUP: {"sequential": few}})
    (entry,) = board([card], BoardKey("gravity", "sequential", "100k", False)).rows
    assert (entry.runs, entry.why) == (3, "Fewer than 5 runs.")


def test_an_entry_has_what_its_agents_observe_and_store(enter: Enter) -> None:
    card = enter("a", 300)
    (entry,) = board([card], KEY).rows
    assert card.manifest is not None
    assert (entry.observes, entry.memory) == (card.manifest.observes, card.manifest.memory)
    assert entry.memory is not None
    assert entry.memory.stored_steps == 2000
