"""The first submission of a board, and the sentence on how certain its lead is."""

import pytest

from gym_extensions.metrics.values import NOTHING_LEARNED
from gym_extensions.site.board_views import BoardView, Leaderboard, shortened
from gym_extensions.site.submission_results import nothing_to_forget
from gym_extensions.site.text import rank

from .browser import references_of, typed
from .conftest import Document, Make, around, estimate


def only(*cards: Document) -> BoardView:
    """The only board of these cards."""
    references = {"version": "made-up", "sha256": ""}
    whole = typed({"format": 1, "references": references, "submissions": list(cards)})
    (board,) = Leaderboard(references_of(whole), tuple(map(shortened, whole.submissions))).boards
    return board


def test_ranks_are_intervals_and_a_single_submission_has_none(make_card: Make) -> None:
    tied = only(make_card("a", around(0.9)), make_card("b", around(0.899)), make_card("c", around(0.1)))
    ranks = [rank(row.rank("final_performance")) for row in tied.rows]
    assert ranks == ["1–2", "1–2", "3"]
    assert [row.rank("final_performance") for row in only(make_card("a", around(0.9))).rows] == [None]


def test_the_least_forgetting_is_among_those_that_learned(make_card: Make) -> None:
    blind = make_card("blind", around(0.0), around(0.0))
    cards = [blind, make_card("a", around(0.5)), make_card("b", around(0.4))]
    scores = [card["groups"]["hopper-gravity-v0"]["sequential"]["metrics"] for card in cards]
    for metrics, lost in zip(scores, (-0.5, 0.2, 0.1), strict=True):
        metrics["forgetting"] = estimate(around(lost))
    least = only(*cards).least_forgetting
    assert least is not None
    assert least.submission.name == "b"


def test_a_submission_without_a_rank_is_not_called_the_best(make_card: Make) -> None:
    board = only(make_card("lucky", around(0.9, runs=4)), make_card("one", around(0.4, runs=1)))
    assert board.least_forgetting is None
    assert board.leader is not None
    assert (board.leader.submission.name, board.leader.submission.ranked) == ("lucky", False)
    ranked = only(make_card("lucky", around(0.9, runs=4)), make_card("full", around(0.4)))
    rows = (ranked.leader, ranked.least_forgetting)
    assert [row.submission.name for row in rows if row] == ["full", "full"]


@pytest.mark.parametrize(
    ("learning", "note"),
    [
        ([0.4, 0.5, 0.6, 0.5, 0.5], ""),
        ([0.05, 0.05, 0.051, 0.05, 0.05], ""),
        ([-0.1, 0.1, 0.0, 0.05, -0.05], "nothing learned to forget"),
        ([0.9, 0.1], "nothing learned to forget, as far as 2 runs can show"),
        ([0.0999], "nothing learned to forget"),
        ([0.1], ""),
    ],
)
def test_an_agent_that_learned_nothing_has_nothing_to_forget(
    make_card: Make, learning: list[float], note: str
) -> None:
    (row,) = only(make_card("a", around(0.5, runs=len(learning)), learning)).rows
    assert (nothing_to_forget(row.result) if row.result.learned_nothing else "") == note
    found = row.submission.metrics["forgetting"].rank_note == NOTHING_LEARNED
    assert found is bool(note), "the scorer disagrees"


@pytest.mark.parametrize(
    ("runs", "sentence"),
    [
        ({"a": around(0.9)}, "It is the only ranked submission"),
        (
            {"a": around(0.9), "b": around(0.5), "c": around(0.4)},
            "significantly better than every other ranked",
        ),
        ({"a": around(0.9, 2)}, "It is the only submission with a score"),
        ({"a": around(0.9, 4), "b": around(0.5, 4)}, "Its interval lies above those of all other"),
        ({"a": around(0.9, 2), **{name: around(0.88, 2) for name in "bcde"}}, "overlaps with 4 others"),
        ({"a": [0.9], "b": around(0.1, 2)}, "It has one run"),
        ({"a": around(0.9, 2), "b": [0.1]}, "Its interval lies above those of all other"),
        ({"a": around(0.9, 2), "b": [0.87]}, "overlaps with another submission"),
        ({"a": around(0.92, wide=3), "b": around(0.9, wide=3)}, "No significant difference from 1 other"),
    ],
)
def test_the_certainty_of_a_lead_follows_from_its_runs(
    make_card: Make, runs: dict[str, list[float]], sentence: str
) -> None:
    lead = only(*(make_card(name, values) for name, values in runs.items())).scored.lead
    assert lead is not None
    assert (lead.name, sentence in lead.certainty) == ("a", True)
