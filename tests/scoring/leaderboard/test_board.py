"""Boards: order, rank intervals, entries without a rank, and scores equal to those of the scorecards."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from itertools import permutations
from pathlib import Path
from typing import Protocol

import pytest

from gym_extensions.catalog.suites import SUITES
from gym_extensions.scoring.leaderboard.board import board, boards
from gym_extensions.scoring.leaderboard.keys import BoardKey, board_keys, strip_for_boards
from gym_extensions.scoring.leaderboard.model import Board, BoardEntry, BoardsDocument, VersusNext
from gym_extensions.scoring.metrics.value import MetricValue
from gym_extensions.scoring.pipeline.score import score_folder
from gym_extensions.scoring.references import References
from gym_extensions.scoring.scorecard.model import Scorecard
from gym_extensions.scoring.scorecard.record import LedgerRecord, Level
from gym_extensions.scoring.scorecard.suites import suite_scores

FIVE = (0, 1, 2, 3, 4)
GROUP = "hopper-gravity-v0"
KEY = BoardKey(GROUP, "sequential", "100k", False)

Value = Callable[[str, int, int, int, int], float]


class Enter(Protocol):
    """Makes the scorecard of an entry whose returns lie around a level."""

    def __call__(
        self,
        name: str,
        level: float,
        *,
        runs: tuple[int, ...] = FIVE,
        task_conditioned: bool = False,
        protocols: tuple[str, ...] = ("sequential",),
        value: Value | None = None,
    ) -> Scorecard: ...


@pytest.fixture(scope="module")
def cards() -> dict[object, Scorecard]:
    """The scorecards of this module, which never change, by how they were made."""
    return {}


@pytest.fixture
def enter(
    submission: Callable[..., Path],
    references: References,
    manifest_text: str,
    cards: dict[object, Scorecard],
) -> Enter:
    def make(
        name: str,
        level: float,
        *,
        runs: tuple[int, ...] = FIVE,
        task_conditioned: bool = False,
        protocols: tuple[str, ...] = ("sequential",),
        value: Value | None = None,
    ) -> Scorecard:
        key = (name, level, runs, task_conditioned, protocols, value)
        if key in cards:
            return cards[key]
        manifest = manifest_text.replace('"smoke"', '"100k"')
        if task_conditioned:
            manifest = manifest.replace("task_in_evaluation = false", "task_in_evaluation = true")

        def around_level(protocol: str, run: int, stage: int, position: int, episode: int) -> float:
            return stage * level / 5 + 10.0 * (run * 3 % 5) + position - episode / 20

        folder = submission(
            name=name, runs=runs, manifest=manifest, protocols=protocols, value=value or around_level
        )
        cards[key] = score_folder(folder, references)
        return cards[key]

    return make


def names(board: Board) -> list[str]:
    return [entry.name for entry in board.rows]


def final_ranks(board: Board) -> list[tuple[int, int] | None]:
    return [entry.metrics["final_performance"].rank for entry in board.rows]


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


def on_gravity(card: Scorecard, mean: float) -> Scorecard:
    """The scorecard with every group of the suite: five runs of each, with that mean and deviation 1."""
    runs = tuple(mean + step / math.sqrt(2.5) for step in range(-2, 3))
    score = card.groups[GROUP]["sequential"]
    metrics = {**score.metrics, "final_performance": MetricValue(mean=mean, runs=runs)}
    groups = {name: {"sequential": replace(score, metrics=metrics)} for name in SUITES["gravity"]}
    return replace(card, groups=groups, suites=suite_scores(groups))


@pytest.mark.parametrize(("where", "gap", "more"), [(GROUP, 1.25, 7), ("gravity", 0.625, 6)])
def test_the_runs_that_would_separate_two_are_those_of_every_group(
    enter: Enter, where: str, gap: float, more: int
) -> None:
    # One and a quarter deviations apart on both: the suite's is half a group's. See test_ranks.
    cards = [on_gravity(enter("high", 900), gap), on_gravity(enter("low", 200), 0.0)]
    high, _ = board(cards, BoardKey(where, "sequential", "100k", False)).rows
    versus = versus_next(high)
    assert (versus.name, versus.separated, versus.more_runs) == ("low", False, more)


def test_entries_with_fewer_runs_are_below_without_a_rank_and_count_nowhere(enter: Enter) -> None:
    made = board([enter("few", 950, runs=(0, 1)), enter("low", 200), enter("high", 900)], KEY)
    assert names(made) == ["high", "low", "few"]
    assert final_ranks(made) == [(1, 1), (2, 2), None]
    assert made.rows[2].why == "Fewer than 5 runs."


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


def test_a_duplicate_entry_follows_the_first_by_name_without_a_rank(enter: Enter) -> None:
    cards = [enter("original", 500), enter("copied", 500), enter("other", 501), enter("again", 500)]
    made = board(cards, KEY)
    assert [(entry.name, entry.duplicate_of, entry.ranked) for entry in made.rows] == [
        ("other", None, True),
        ("again", None, True),
        ("copied", "again", False),
        ("original", "again", False),
    ]
    assert made.rows[2].why == "Has most episodes of again."
    assert made.ranked == 2


def test_of_identical_entries_the_replayed_one_counts(enter: Enter) -> None:
    replayed = replace(enter("b", 500), trust="replayed (300 of 14000 episodes)")
    rows = board([enter("a", 500), replayed], KEY).rows
    assert [(entry.name, entry.duplicate_of) for entry in rows] == [("b", None), ("a", "b")]


def test_of_identical_replayed_entries_the_one_that_was_accepted_first_counts(enter: Enter) -> None:
    def accepted(name: str, date: str, level: Level) -> Scorecard:
        record = LedgerRecord(event="accepted", digest="", accepted=date, level=level)
        return replace(enter(name, 500), trust=f"{level} (300 of 14000 episodes)", ledger=record)

    levels: tuple[Level, ...] = ("replayed", "re-evaluated", "reproduced")
    for level in levels:
        cards = [accepted("a", "2026-02-01", "replayed"), accepted("b", "2026-01-01", level)]
        rows = board(cards, KEY).rows
        assert [(entry.name, entry.duplicate_of) for entry in rows] == [("b", None), ("a", "b")]


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
