"""Builds boards, which rank the entries of one group or suite, protocol and budget.

A board is made from scorecards alone. What it adds (ranks, runs to separate) belongs to the board and may
change when an entry joins; the scores are copied from the scorecards and never move.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from gym_extensions.catalog.groups import GROUPS
from gym_extensions.catalog.protocol import FULL_ENTRY_RUNS
from gym_extensions.catalog.suites import SUITES
from gym_extensions.scoring.leaderboard.duplicates import duplicate_entries
from gym_extensions.scoring.leaderboard.keys import BoardKey, board_keys, lookup
from gym_extensions.scoring.leaderboard.model import Board, BoardEntry, BoardMetric, BoardsDocument
from gym_extensions.scoring.leaderboard.ranks import ranked_on
from gym_extensions.scoring.leaderboard.related import related_entries
from gym_extensions.scoring.metrics.definitions import METRICS
from gym_extensions.scoring.metrics.value import MetricValue, learned_nothing
from gym_extensions.scoring.scorecard.model import REPORTED, GroupScore, Scorecard, SuiteScore
from gym_extensions.scoring.scorecard.sketches import Sketch

NOT_ACCEPTED = "Not accepted yet: the ledger does not have its files."
NOTHING_LEARNED = "nothing learned to forget"
FORGETTING = ("forgetting", "worst_case_forgetting", "mean_later_forgetting")
ABOVE_VALIDATED = ("replayed", "re-evaluated", "reproduced")
"""How the levels of trust of replayed entries begin."""
LAST_DATE = "9999"
"""Sorts after every date."""


def _why_not_ranked(
    card: Scorecard, key: BoardKey, runs: int, first: MetricValue, duplicate: str | None
) -> str:
    if card.trust == REPORTED:
        return "Reported from a publication: no logs."
    if card.ledger and card.ledger.is_pending:
        return NOT_ACCEPTED
    if duplicate:
        return f"Has most episodes of {duplicate}."
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
    why = _why_not_ranked(card, key, runs, score.metrics[METRICS[key.protocol][0].name], duplicate)
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
        authors=card.manifest.authors if card.manifest else (),
        accepted=card.ledger.accepted if card.ledger else "",
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


def _original_first(card: Scorecard) -> tuple[bool, str, str]:
    """Sorts entries: of identical ones, a replayed one counts, then the one that the ledger accepted first,
    then the first by name."""
    accepted = card.ledger.accepted if card.ledger else ""
    return (not (card.trust or "").startswith(ABOVE_VALIDATED), accepted or LAST_DATE, card.name)


def _sorted(entries: Sequence[BoardEntry], metric: str) -> list[BoardEntry]:
    """Ranked entries, best first, then the others; an identical entry follows the one that it equals."""

    def order(entry: BoardEntry) -> tuple[bool, float, str]:
        mean = entry.metrics[metric].mean
        return (not entry.ranked, float("inf") if mean is None else -mean, entry.name)

    identical: dict[str | None, list[BoardEntry]] = {}
    for entry in sorted(entries, key=order):
        identical.setdefault(entry.duplicate_of, []).append(entry)
    return [row for entry in identical.get(None, ()) for row in (entry, *identical.get(entry.name, ()))]


def _sketches(card: Scorecard, key: BoardKey) -> list[Sketch]:
    """The sketches of all runs on a board; those of a suite are told apart by their group."""
    return [
        tuple(f"{name} {digest}" for digest in sketch)
        for name in key.groups
        for sketch in card.groups[name][key.protocol].episode_sketches
    ]


def board(cards: Sequence[Scorecard], key: BoardKey) -> Board:
    """One board. Ranked entries come first, best first by their first metric, then those without a rank.

    An entry with most episodes of another follows it, without a rank.
    """
    on_board = [card for card in cards if lookup(card, key) is not None]
    cards_by_name = {card.name: card for card in sorted(on_board, key=_original_first)}
    scores = {name: score for name, card in cards_by_name.items() if (score := lookup(card, key))}
    duplicates = duplicate_entries({name: _sketches(card, key) for name, card in cards_by_name.items()})
    related = related_entries(cards_by_name)
    first, *others = METRICS[key.protocol]
    entries = _sorted(
        [
            _entry(cards_by_name[name], key, score, duplicates.get(name), related[name])
            for name, score in scores.items()
        ],
        first.name,
    )
    ranked = ranked_on(entries, cards_by_name, key, first)
    ranks = {first.name: ranked.intervals(first.better)}
    for metric in others:
        ranks[metric.name] = ranked_on(entries, cards_by_name, key, metric).intervals(metric.better)
    vs_next, vs_leader = ranked.vs_next(), ranked.vs_leader()
    rows = [
        replace(
            entry,
            vs_next=vs_next.get(entry.name),
            vs_leader=vs_leader.get(entry.name),
            metrics={
                name: replace(value, rank=ranks[name].get(entry.name))
                for name, value in entry.metrics.items()
            },
        )
        for entry in entries
    ]
    count = sum(entry.ranked for entry in entries)
    published = key.group in SUITES or key.group in {group.id for group in GROUPS.values()}
    return Board(key.group, published, key.protocol, key.budget, key.task_conditioned, count, tuple(rows))


def boards(cards: Sequence[Scorecard]) -> BoardsDocument:
    """Every board of the scorecards. Those that the ledger withdrew or superseded are left out."""
    shown = [card for card in cards if card.ledger is None or card.ledger.on_boards]
    return BoardsDocument(boards=tuple(board(shown, key) for key in board_keys(shown)))
