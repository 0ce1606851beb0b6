"""Boards: the entries of one group or suite, protocol and budget, side by side with their rank intervals.

A board is made of scorecards and of nothing else. What it adds (ranks, runs to separate) belongs to the
board and may change when somebody joins; the scores themselves are copied from the scorecards and never
move.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from gym_extensions.catalog.protocol import FULL_ENTRY_RUNS
from gym_extensions.scoring.leaderboard.duplicates import repeats
from gym_extensions.scoring.leaderboard.keys import BoardKey, board_keys, place, told
from gym_extensions.scoring.metrics.definitions import METRICS
from gym_extensions.scoring.scorecard.build import REPORTED
from gym_extensions.scoring.scorecard.estimates import estimate
from gym_extensions.scoring.statistics.intervals import Summary, subtract, to_interval
from gym_extensions.scoring.statistics.ranking import rank_intervals, runs_to_separate
from gym_extensions.scoring.statistics.welch import significant_pairs

Document = dict[str, Any]
Ranked = tuple[Document, Summary]

NOTHING_LEARNED = "nothing learned to forget"
FORGETTING = ("forgetting", "worst_case_forgetting", "forgetting_all_later_stages")
LEAST_LEARNED = 0.1
"""Learning performance from which one run counts as having learned something; it has no interval."""


def _runs(card: Document, key: BoardKey) -> int:
    return min(len(card["groups"][name][key.protocol]["runs"]) for name in key.groups)


def _unlearned(metrics: Mapping[str, Document]) -> bool:
    """Whether an entry has learned nothing that it could forget."""
    learned = metrics.get("learning_performance")
    if learned is None or learned["mean"] is None:
        return False
    low: float | None = learned["low"]
    return learned["mean"] < LEAST_LEARNED if low is None else low <= 0


def _entry(card: Document, key: BoardKey, found: Document) -> Document:
    runs = _runs(card, key)
    why = f"Fewer than {FULL_ENTRY_RUNS} runs." if runs < FULL_ENTRY_RUNS else ""
    why = "Reported from a publication: no logs." if card["trust"] == REPORTED else why
    metrics = {
        name: {key: score.get(key) for key in ("mean", "low", "high", "why") if key in score} | {"rank": None}
        for name, score in found["metrics"].items()
    }
    if _unlearned(found["metrics"]):
        for name in FORGETTING:
            metrics[name]["instead"] = NOTHING_LEARNED
    return {
        "name": card["name"],
        "title": card["title"],
        "trust": card["trust"],
        "runs": runs,
        "ranked": not why,
        "observes": card["manifest"]["observes"],
        "memory": card["manifest"]["memory"],
        "metrics": metrics,
    } | ({"why": why} if why else {})


def _rank(rows: Sequence[Document], cards: Mapping[str, Document], key: BoardKey) -> None:
    """Fills in the rank intervals of every metric, and ``next`` of every ranked row but the last."""
    for metric in METRICS[key.protocol]:
        ranked = [
            (row, found)
            for row in rows
            if row["ranked"] and "instead" not in row["metrics"][metric.name]
            if (found := estimate(cards[row["name"]]["groups"], key.groups, key.protocol, metric)) is not None
            if found.runs >= FULL_ENTRY_RUNS
        ]
        if not metric.better or not ranked:
            continue
        entries = [entry for _, entry in ranked]
        apart = significant_pairs(entries)
        for (row, _), ranks in zip(ranked, rank_intervals(entries, apart, metric.better), strict=True):
            row["metrics"][metric.name]["rank"] = list(ranks)
        if metric is METRICS[key.protocol][0]:
            for above, (row, _) in enumerate(ranked[:-1]):
                row["next"] = _next(
                    ranked[above], ranked[above + 1], bool(apart[above, above + 1]), len(ranked)
                )


def _next(row: Ranked, below: Ranked, apart: bool, ranked: int) -> Document:
    """How a ranked entry stands against the next: the pair's own interval, and what would separate them."""
    gap = subtract(row[1], below[1])
    between, needed = to_interval(gap), runs_to_separate(gap, ranked)
    more = None if needed is None else max(1, needed - min(row[0]["runs"], below[0]["runs"]))
    return {
        "name": below[0]["name"],
        "difference": {"mean": between.mean, "low": between.low, "high": between.high},
        "separated": apart,
        "more_runs": 0 if apart else more,
    }


def board(cards: Sequence[Document], key: BoardKey) -> Document:
    """One board: ranked entries by their first metric, best first, then those without a rank.

    Args:
        cards: scorecards, as ``score_folders`` gives them under ``submissions``.
        key: which board.

    Returns:
        The board as docs/scorecard.md describes it: ``rows`` with every metric's mean, interval and rank
        interval (first and last possible rank, null without one); for each ranked row ``next``, the one
        below it; ``same_as`` where an entry repeats another.
    """
    places = ((card, place(card, key)) for card in cards if told(card) == key.told)
    here = {card["name"]: (card, found) for card, found in places if found and found["budget"] == key.budget}
    same = repeats({name: found for name, (_, found) in here.items()})
    rows = [
        _entry(card, key, found) | ({"same_as": same[name]} if name in same else {})
        for name, (card, found) in here.items()
    ]
    first = METRICS[key.protocol][0].name
    for row in rows:
        if row["ranked"] and row["metrics"][first]["mean"] is None:
            row["ranked"], row["why"] = False, row["metrics"][first]["why"]

    def order(row: Document) -> tuple[bool, float, str]:
        mean = row["metrics"][first]["mean"]
        return (not row["ranked"], float("inf") if mean is None else -mean, row["name"])

    rows.sort(key=order)
    _rank(rows, {name: card for name, (card, _) in here.items()}, key)
    return {
        "group": key.group,
        "protocol": key.protocol,
        "budget": key.budget,
        "told_the_task": key.told,
        "ranked": sum(row["ranked"] for row in rows),
        "rows": rows,
    }


def boards(cards: Sequence[Document]) -> list[Document]:
    """Every board of the scorecards."""
    return [board(cards, key) for key in board_keys(cards)]
