"""Builds boards, which rank the entries of one group or suite, protocol and budget.

A board is made from scorecards and the references alone. What it adds (ranks, differences, runs to separate)
belongs to the board and may change when an entry joins; the scores are copied and never move.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

from gym_extensions.catalog.groups import GROUPS, SUITES
from gym_extensions.catalog.protocol import FULL_ENTRY_RUNS, PROTOCOLS
from gym_extensions.rollouts.review import REPORTED, Level
from gym_extensions.scoring.entry.values import NEEDS, estimate
from gym_extensions.scoring.formulas import (
    BOARD_METRICS,
    NOTHING_LEARNED,
    Metric,
    MetricValue,
    learned_nothing,
)
from gym_extensions.scoring.ranking.boards import (
    Board,
    BoardEntry,
    BoardKey,
    BoardMetric,
    BoardsDocument,
    Difference,
    Pair,
    Versus,
    best_first,
    board_keys,
    board_level,
    is_verified,
    lookup,
)
from gym_extensions.scoring.ranking.computed_rows import computed_rows
from gym_extensions.scoring.ranking.copies import copy_of, duplicates, related_entries
from gym_extensions.scoring.ranking.core_board import core_board
from gym_extensions.scoring.references import References, load_references
from gym_extensions.scoring.scorecard import GroupScore, Scorecard
from gym_extensions.scoring.statistics import Mask, Summary, rank_intervals, significant_pairs

MAX_PAIRED = 60
"""Entries of a board whose differences it lists."""
Summaries = Mapping[str, Mapping[str, Summary | None]]
"""The summary over runs by metric and entry; None where the entry has no value."""


def boards(cards: Sequence[Scorecard], references: References | None = None) -> BoardsDocument:
    """Every board of the scorecards. Withdrawn entries are left out.

    ``references`` are those of the computed rows, the current benchmark version's where None.
    """
    references = references or load_references()
    shown = [card for card in cards if not card.withdrawn]
    made = tuple(board(shown, key, references) for key in board_keys(shown))
    return BoardsDocument(core=core_board(shown), boards=made)


def board(cards: Sequence[Scorecard], key: BoardKey, references: References | None = None) -> Board:
    """One board. Ranked entries come first, best first by their first metric, then those without a rank.

    An entry with most episodes of another follows it, without a rank. Scorecards that are not on the board
    are left out. ``references`` are as in :func:`boards`.
    """
    references = references or load_references()
    by_name = {card.name: card for card in cards if lookup(card, key)}
    copies, related = duplicates(list(by_name.values()), key), related_entries(by_name)
    metrics = BOARD_METRICS[key.protocol]
    first = metrics[0]
    made = [_entry(card, key, copies.get(name), related[name]) for name, card in by_name.items()]
    entries = _sorted(made, first)
    summaries = {
        metric.name: {
            name: estimate(card.groups, key.groups, key.protocol, metric) for name, card in by_name.items()
        }
        for metric in metrics
    }
    ranked = {metric.name: _ranked_on(entries, summaries, metric) for metric in metrics}
    ranks = {metric.name: ranked[metric.name].ranks(metric.better) for metric in metrics}
    top = ranked[first.name]
    vs_next = {name: top.versus(name, place) for place, name in enumerate(top.names[:-1], 1)}
    vs_leader = {name: top.versus(name, 0) for name in top.names[1:]}

    def with_ranks(entry: BoardEntry) -> BoardEntry:
        name, metrics = entry.name, entry.metrics.items()
        ranked = {each: replace(value, rank=ranks[each].get(name)) for each, value in metrics}
        return replace(entry, metrics=ranked, vs_next=vs_next.get(name), vs_leader=vs_leader.get(name))

    with_logs = next((card for card in by_name.values() if card.level != REPORTED), None)
    tasks = {name: with_logs.groups[name][key.protocol].tasks for name in key.groups} if with_logs else {}
    return Board(
        group=key.group,
        published=key.group in SUITES or key.group in {group.id for group in GROUPS.values()},
        protocol=key.protocol,
        budget=key.budget,
        task_conditioned=key.task_conditioned,
        ranked=sum(entry.ranked for entry in entries),
        rows=tuple(map(with_ranks, entries)),
        computed=computed_rows(key, references, tasks, by_name) if tasks else (),
        pairs=_pairs(entries, summaries),
    )


@dataclass(frozen=True)
class Ranked:
    """The M entries that a board ranks on one metric, in the order of the board, with their values over runs.

    ``significant`` is M × M, True where the board's test separates two entries.
    """

    names: tuple[str, ...]
    summaries: tuple[Summary, ...]
    significant: Mask

    def ranks(self, better: str) -> dict[str, tuple[int, int]]:
        """The rank interval of each entry by name."""
        return dict(zip(self.names, rank_intervals(self.summaries, self.significant, better), strict=True))

    def versus(self, name: str, other: int) -> Versus:
        """An entry against the one at another place."""
        place = self.names.index(name)
        above, below = (self.summaries[index] for index in sorted((place, other)))
        return Versus(self.names[other], Difference.of(above, below), bool(self.significant[place, other]))


def _ranked_on(entries: Sequence[BoardEntry], summaries: Summaries, metric: Metric) -> Ranked:
    """The ranked entries that have a value of the metric over enough runs, each pair compared."""
    ranked = {
        entry.name: summary
        for entry in entries
        if metric.better and entry.ranked and not entry.metrics[metric.name].rank_note
        if (summary := summaries[metric.name][entry.name]) is not None
        if summary.runs >= FULL_ENTRY_RUNS
    }
    values = tuple(ranked.values())
    return Ranked(tuple(ranked), values, significant_pairs(values))


def _pairs(entries: Sequence[BoardEntry], summaries: Summaries) -> tuple[Pair, ...]:
    """The difference of every two entries, of every metric that both have."""
    pairs = []
    for above, below in combinations([entry.name for entry in entries[:MAX_PAIRED]], 2):
        both = {name: (values[above], values[below]) for name, values in summaries.items()}
        metrics = {name: Difference.of(a, b) for name, (a, b) in both.items() if a and b}
        if metrics:
            pairs.append(Pair(above, below, metrics))
    return tuple(pairs)


def _why_not_ranked(logs: Sequence[GroupScore], level: Level, first: MetricValue, copied: str | None) -> str:
    if level == REPORTED:
        return "Reported from a publication: no logs."
    if copied:
        return copy_of(copied)
    if not is_verified(level):
        return f"Claimed: {next(filter(None, (log.why_claimed for log in logs)), 'not verified.')}"
    if min(len(log.runs) for log in logs) < FULL_ENTRY_RUNS:
        return f"Fewer than {FULL_ENTRY_RUNS} runs."
    return first.why if first.mean is None else ""


def _rank_note(card: Scorecard, key: BoardKey, metric: Metric, is_unlearned: bool) -> str:
    """Why an entry with a rank has none on this metric; empty if it has one."""
    if is_unlearned and metric.name == "forgetting":
        return NOTHING_LEARNED
    for protocol in metric.needs:
        if protocol in PROTOCOLS and not is_verified(board_level(card, key, protocol)):
            return f"the {NEEDS[protocol]} are not verified"
    return ""


def _entry(card: Scorecard, key: BoardKey, copied: str | None, related: tuple[str, ...]) -> BoardEntry:
    logs, score = [card.groups[name][key.protocol] for name in key.groups], lookup(card, key)
    assert score is not None, "it is on the board"
    level, metrics = board_level(card, key), BOARD_METRICS[key.protocol]
    why = _why_not_ranked(logs, level, score.metrics[metrics[0].name], copied)
    is_unlearned = learned_nothing(score.metrics)
    manifest = card.manifest
    return BoardEntry(
        name=card.name,
        title=card.title,
        level=level,
        runs=min(len(log.runs) for log in logs),
        ranked=not why,
        why=why,
        steps=manifest.protocol.steps if manifest else None,
        evaluation=manifest.protocol.evaluation if manifest else None,
        authors=manifest.authors if manifest else (),
        accepted=card.accepted,
        observes=manifest.observes if manifest else None,
        memory=manifest.memory if manifest else None,
        metrics={
            each.name: BoardMetric.of(score.metrics[each.name], _rank_note(card, key, each, is_unlearned))
            for each in metrics
        },
        duplicate_of=copied,
        related=related,
    )


def _sorted(entries: Sequence[BoardEntry], metric: Metric) -> list[BoardEntry]:
    """Ranked entries, best first, then the others; an identical entry follows the one that it equals."""
    identical: dict[str | None, list[BoardEntry]] = {}
    for entry in best_first(entries, metric):
        identical.setdefault(entry.duplicate_of, []).append(entry)
    return [row for entry in identical.get(None, ()) for row in (entry, *identical.get(entry.name, ()))]
