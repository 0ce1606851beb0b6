"""Entries with the same episodes on a board: one of them counts, the others follow it without a rank."""

from __future__ import annotations

from dataclasses import replace

from gym_extensions.scoring.leaderboard.board import board
from gym_extensions.scoring.scorecard.model import Scorecard
from gym_extensions.scoring.scorecard.record import LedgerRecord, Level

from .entries import KEY, Enter


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
