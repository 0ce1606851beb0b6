"""Builds boards, which rank the entries of one group or suite, protocol and budget.

A board is made from scorecards alone. What it adds (ranks, runs to separate) belongs to the board and may
change when an entry joins; the scores are copied from the scorecards and never move.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from gym_extensions.catalog.groups import GROUPS
from gym_extensions.catalog.protocol import FULL_ENTRY_RUNS
from gym_extensions.catalog.suites import SUITES
from gym_extensions.scoring.leaderboard.duplicates import duplicate_entries
from gym_extensions.scoring.leaderboard.keys import BoardKey, board_keys, lookup
from gym_extensions.scoring.leaderboard.model import (
    Board,
    BoardEntry,
    BoardMetric,
    BoardsDocument,
    Difference,
    VersusNext,
)
from gym_extensions.scoring.leaderboard.related import related_entries
from gym_extensions.scoring.metrics.definitions import METRICS
from gym_extensions.scoring.metrics.metric import Metric
from gym_extensions.scoring.metrics.value import MetricValue, learned_nothing
from gym_extensions.scoring.scorecard.estimates import estimate
from gym_extensions.scoring.scorecard.model import REPORTED, GroupScore, Scorecard, SuiteScore
from gym_extensions.scoring.scorecard.sketches import Sketch
from gym_extensions.scoring.statistics.intervals import Summary, subtract, to_interval
from gym_extensions.scoring.statistics.ranking import rank_intervals, runs_to_separate
from gym_extensions.scoring.statistics.welch import significant_pairs

NOT_ACCEPTED = "Not accepted yet: the ledger does not have its files."
NOTHING_LEARNED = "nothing learned to forget"
FORGETTING = ("forgetting", "worst_case_forgetting", "mean_later_forgetting")


@dataclass(frozen=True)
class Ranks:
    """The ranks of one metric, with rank intervals by entry name and each ranked entry against the next."""

    intervals: Mapping[str, tuple[int, int]]
    vs_next: Mapping[str, VersusNext]


def _why_not_ranked(card: Scorecard, key: BoardKey, runs: int, first: MetricValue) -> str:
    if card.trust == REPORTED:
        return "Reported from a publication: no logs."
    if card.ledger and card.ledger.is_pending:
        return NOT_ACCEPTED
    if runs < FULL_ENTRY_RUNS:
        return f"Fewer than {FULL_ENTRY_RUNS} runs."
    evidence = (card.groups[name][key.protocol].missing_evidence for name in key.groups)
    return next(filter(None, evidence), first.why if first.mean is None else "")


def _entry(
    card: Scorecard,
    key: BoardKey,
    score: GroupScore | SuiteScore,
    duplicate: str | None,
    related: tuple[str, ...],
) -> BoardEntry:
    runs = min(len(card.groups[name][key.protocol].runs) for name in key.groups)
    why = _why_not_ranked(card, key, runs, score.metrics[METRICS[key.protocol][0].name])
    unranked = FORGETTING if learned_nothing(score.metrics) else ()
    return BoardEntry(
        name=card.name,
        title=card.title,
        trust=card.trust,
        runs=runs,
        ranked=not why,
        why=why,
        steps=card.manifest.protocol.steps if card.manifest else None,
        evaluation=card.manifest.protocol.evaluation if card.manifest else None,
        observes=card.manifest.observes if card.manifest else None,
        memory=card.manifest.memory if card.manifest else None,
        metrics={
            name: BoardMetric(
                value.mean,
                value.low,
                value.high,
                value.why,
                rank_note=NOTHING_LEARNED if name in unranked else "",
            )
            for name, value in score.metrics.items()
        },
        duplicate_of=duplicate,
        related=related,
    )


def _ranks(
    entries: Sequence[BoardEntry], cards: Mapping[str, Scorecard], key: BoardKey, metric: Metric
) -> Ranks:
    """Ranks of the entries that have a value of the metric over enough runs."""
    ranked = [
        (entry, summary)
        for entry in entries
        if metric.better and entry.ranked and not entry.metrics[metric.name].rank_note
        if (summary := estimate(cards[entry.name].groups, key.groups, key.protocol, metric)) is not None
        if summary.runs >= FULL_ENTRY_RUNS
    ]
    if not ranked:
        return Ranks({}, {})
    summaries = [summary for _, summary in ranked]
    apart = significant_pairs(summaries)
    intervals = rank_intervals(summaries, apart, metric.better)
    return Ranks(
        {entry.name: interval for (entry, _), interval in zip(ranked, intervals, strict=True)},
        {
            above[0].name: _versus(above, below, bool(apart[index, index + 1]), len(ranked))
            for index, (above, below) in enumerate(pairwise(ranked))
        },
    )


def _versus(
    above: tuple[BoardEntry, Summary], below: tuple[BoardEntry, Summary], separated: bool, entries: int
) -> VersusNext:
    """A ranked entry against the next, with the interval of the pair and the runs to separate them."""
    gap = subtract(above[1], below[1])
    needed = None if separated else runs_to_separate(gap, entries)
    more = None if needed is None else max(1, needed - min(above[0].runs, below[0].runs))
    return VersusNext(below[0].name, Difference.of(to_interval(gap)), separated, 0 if separated else more)


def _sketches(card: Scorecard, key: BoardKey) -> list[Sketch]:
    """The sketches of all runs on a board; those of a suite are told apart by their group."""
    return [
        tuple(f"{name} {digest}" for digest in sketch)
        for name in key.groups
        for sketch in card.groups[name][key.protocol].episode_sketches
    ]


def board(cards: Sequence[Scorecard], key: BoardKey) -> Board:
    """One board. Ranked entries come first, best first by their first metric, then those without a rank."""
    scores = {card.name: score for card in cards if (score := lookup(card, key)) is not None}
    cards_by_name = {card.name: card for card in cards if card.name in scores}
    duplicates = duplicate_entries({name: _sketches(card, key) for name, card in cards_by_name.items()})
    related = related_entries(cards_by_name)
    first = METRICS[key.protocol][0]

    def order(entry: BoardEntry) -> tuple[bool, float, str]:
        mean = entry.metrics[first.name].mean
        return (not entry.ranked, float("inf") if mean is None else -mean, entry.name)

    entries = sorted(
        (
            _entry(cards_by_name[name], key, score, duplicates.get(name), related[name])
            for name, score in scores.items()
        ),
        key=order,
    )
    ranks = {metric.name: _ranks(entries, cards_by_name, key, metric) for metric in METRICS[key.protocol]}
    rows = [
        replace(
            entry,
            vs_next=ranks[first.name].vs_next.get(entry.name),
            metrics={
                name: replace(value, rank=ranks[name].intervals.get(entry.name))
                for name, value in entry.metrics.items()
            },
        )
        for entry in entries
    ]
    ranked = sum(entry.ranked for entry in entries)
    published = key.group in SUITES or key.group in {group.id for group in GROUPS.values()}
    return Board(key.group, published, key.protocol, key.budget, key.task_conditioned, ranked, tuple(rows))


def boards(cards: Sequence[Scorecard]) -> BoardsDocument:
    """Every board of the scorecards. Those that the ledger withdrew or superseded are left out."""
    shown = [card for card in cards if card.ledger is None or card.ledger.on_boards]
    return BoardsDocument(boards=tuple(board(shown, key) for key in board_keys(shown)))
