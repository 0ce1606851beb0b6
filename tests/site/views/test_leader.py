"""The first entry of a board, and the sentence on how certain its lead is."""

from __future__ import annotations

import pytest

from .made_boards import Make, around, only


@pytest.mark.parametrize(
    ("runs", "sentence"),
    [
        ({"a": around(0.9)}, "It is the only ranked entry."),
        (
            {"a": around(0.9), "b": around(0.5), "c": around(0.4)},
            "It is significantly better than every other ranked entry (95\u202f% confidence).",
        ),
        ({"a": around(0.9, runs=2)}, "It is the only entry with a score."),
        (
            {"a": around(0.9, runs=4), "b": around(0.5, runs=4)},
            "Its interval lies above the intervals of all other entries.",
        ),
        (
            {"a": around(0.9, runs=2), "b": around(0.85, runs=2), "c": around(0.82, runs=2)},
            "Its interval overlaps with B (b) and C (c), so the order may be due to chance.",
        ),
        (
            {"a": around(0.9, runs=2), **{name: around(0.88, runs=2) for name in "bcde"}},
            "Its interval overlaps with 4 others, so the order may be due to chance.",
        ),
        (
            {"a": [0.9], "b": around(0.1, runs=2)},
            "It has one run, so its uncertainty is unknown.",
        ),
        (
            {"a": around(0.9, runs=2), "b": [0.1]},
            "Its interval lies above the intervals and single runs of all other entries.",
        ),
        (
            {"a": around(0.9, runs=2), "b": [0.87]},
            "Its interval overlaps with B (b), so the order may be due to chance.",
        ),
    ],
)
def test_the_certainty_of_a_lead_follows_from_its_runs(
    entry: Make, runs: dict[str, list[float]], sentence: str
) -> None:
    leader = only(*(entry(name, values) for name, values in runs.items())).leader
    assert leader is not None
    assert (leader.row.entry.name, leader.certainty) == ("a", sentence)


def test_a_tie_at_the_top_has_its_size_and_the_interval_of_the_distance(entry: Make) -> None:
    leader = only(entry("a", around(0.92, wide=3)), entry("b", around(0.9, wide=3))).leader
    assert leader is not None
    # Difference .02; s = .0474 on both sides: √(2 · .0474² / 5) = .03, t(.975, 8) = 2.306: ± .0692.
    assert leader.certainty == (
        "A tie at the top of 2 entries. Its distance to B (b) is 0.02, "
        "and could be anything from −0.05 to 0.09."
    )


@pytest.mark.parametrize(("ahead", "ends"), [(0.0001, "−0.07 to 0.07"), (0.0049, "−0.06 to 0.07")])
def test_a_difference_that_two_digits_do_not_show_is_zero(entry: Make, ahead: float, ends: str) -> None:
    leader = only(entry("a", around(0.5 + ahead, wide=3)), entry("b", around(0.5, wide=3))).leader
    assert leader is not None
    assert leader.certainty.endswith(f"Its distance to B (b) is 0.00, and could be anything from {ends}.")


def test_a_small_significant_difference_is_not_zero(entry: Make) -> None:
    three = {"a": 0.504, "b": 0.5, "c": 0.5}
    cards = [entry(name, around(mean, wide=0.01)) for name, mean in three.items()]
    cards[2] = entry("c", around(0.499, wide=9))
    leader = only(*cards).leader
    assert leader is not None
    assert leader.certainty == (
        "A tie at the top of 2 entries. "
        "It is significantly better than B (b), by less than 0.01, but not than all others."
    )


def test_a_ranked_entry_leads_before_a_better_one_with_fewer_runs(entry: Make) -> None:
    leader = only(entry("lucky", around(0.9, runs=1)), entry("full", around(0.4))).leader
    assert leader is not None
    assert leader.row.entry.name == "full"


def test_a_board_without_scores_has_no_leader(entry: Make) -> None:
    assert only(entry("a", None)).leader is None
