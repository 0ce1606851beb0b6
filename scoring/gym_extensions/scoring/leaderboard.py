"""Builds boards, which rank the entries of one group or suite, protocol and budget, and compares two entries.

A board is made from scorecards and the references alone. What it adds (ranks, differences, runs to separate)
belongs to the board and may change when an entry joins; the scores are copied and never move.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, pairwise

from gym_extensions.catalog.groups import CORE, GROUPS, SUITES
from gym_extensions.catalog.protocol import FULL_ENTRY_RUNS, PROTOCOLS, STANDARD_BUDGET
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.review import LEVELS, REPORTED, VERIFIED, Level
from gym_extensions.scoring.boards import (
    Board,
    BoardEntry,
    BoardKey,
    BoardMetric,
    BoardsDocument,
    ComparedMetric,
    ComparedScore,
    ComparedScores,
    Comparison,
    CoreBoard,
    Difference,
    Pair,
    VersusLeader,
    VersusNext,
    board_keys,
    lookup,
)
from gym_extensions.scoring.comparisons import core_board, is_on_core
from gym_extensions.scoring.computed import computed_rows
from gym_extensions.scoring.metrics import (
    BOARD_METRICS,
    METRICS,
    NOTHING_LEARNED,
    Metric,
    MetricValue,
    learned_nothing,
)
from gym_extensions.scoring.references import References, load_references
from gym_extensions.scoring.returns import NEEDS
from gym_extensions.scoring.scorecard import GroupScore, Scorecard, SuiteScore
from gym_extensions.scoring.scorer import estimate
from gym_extensions.scoring.signs import SHARE, Sketch, is_common
from gym_extensions.scoring.statistics import (
    Mask,
    Summary,
    rank_intervals,
    significant_pairs,
)

FORGETTING = "forgetting"
MAX_PAIRED = 60
"""Entries of a board whose differences it lists."""
LAST_DATE = "9999"
"""Sorts after every date."""
Summaries = Mapping[str, Mapping[str, Summary | None]]
"""The summary over runs by metric and entry; None where the entry has no value."""


def duplicate_entries(entries: Mapping[str, Sequence[Sketch]]) -> dict[str, str]:
    """The original that shares most episodes with an entry, by the name of the later entry.

    Two entries share most episodes if half of the runs of either do: a copy with further runs, with changed
    runs or episodes, or without its training curves is still recognized.

    Args:
        entries: the sketches of the runs by the entry's name. Of entries that share most episodes, the first
            of the mapping is the original. Entries without runs share nothing.
    """
    holders: dict[str, list[str]] = defaultdict(list)
    duplicates: dict[str, str] = {}
    order = {name: index for index, name in enumerate(entries)}
    for name, sketches in entries.items():
        digests = {digest for sketch in sketches for digest in sketch}
        earlier = sorted({other for digest in digests for other in holders[digest]}, key=order.__getitem__)
        original = next((other for other in earlier if _share(sketches, entries[other])), None)
        if original is not None:
            duplicates[name] = original
            continue
        for digest in digests:
            holders[digest].append(name)
    return duplicates


def _share(first: Sequence[Sketch], second: Sequence[Sketch]) -> bool:
    return any(
        sum(any(is_common(run, other) for other in theirs) for run in ours) >= SHARE * len(ours)
        for ours, theirs in ((first, second), (second, first))
    )


def family(algorithm: str) -> str:
    """The family of an algorithm: its name up to the first character that is not a letter or digit.

    >>> family("trpo-2017"), family("SAC_fresh_buffer")
    ('trpo', 'sac')
    """
    return re.split(r"[\W_]", algorithm.strip().casefold(), maxsplit=1)[0]


def related_entries(cards: Mapping[str, Scorecard]) -> dict[str, tuple[str, ...]]:
    """The names of the other entries with a common author and the same family, sorted, by name of the entry.

    Args:
        cards: scorecards of the entries of a board, by name.
    """
    names: dict[tuple[str, str], set[str]] = {}
    for name, card in cards.items():
        if card.manifest is None:
            continue
        algorithm = family(card.manifest.protocol.algorithm)
        for author in card.manifest.authors:
            names.setdefault((" ".join(author.split()).casefold(), algorithm), set()).add(name)
    related: dict[str, set[str]] = {name: set() for name in cards}
    for group in names.values():
        for name in group:
            related[name] |= group - {name}
    return {name: tuple(sorted(others)) for name, others in related.items()}


@dataclass(frozen=True)
class Ranked:
    """The entries that a board ranks on one metric, in the order of the board.

    Attributes:
        entries: name and summary over runs of each.
        significant: M × M, True where the board's test separates two entries.
    """

    entries: tuple[tuple[str, Summary], ...]
    significant: Mask

    def intervals(self, better: str) -> dict[str, tuple[int, int]]:
        """The rank interval of each entry by name."""
        if not self.entries:
            return {}
        names, summaries = zip(*self.entries, strict=True)
        return dict(zip(names, rank_intervals(summaries, self.significant, better), strict=True))

    def vs_next(self) -> dict[str, VersusNext]:
        """Each entry but the last against the next."""
        return {
            name: VersusNext(below, Difference.of(first, second), bool(self.significant[index, index + 1]))
            for index, ((name, first), (below, second)) in enumerate(pairwise(self.entries))
        }

    def vs_leader(self) -> dict[str, VersusLeader]:
        """Each entry but the first against the first."""
        if not self.entries:
            return {}
        leader, first = self.entries[0]
        return {
            name: VersusLeader(leader, Difference.of(first, other), bool(self.significant[0, index]))
            for index, (name, other) in enumerate(self.entries[1:], 1)
        }


def _ranked_on(entries: Sequence[BoardEntry], summaries: Summaries, metric: Metric) -> Ranked:
    """The ranked entries that have a value of the metric over enough runs, each pair compared."""
    ranked = tuple(
        (entry.name, summary)
        for entry in entries
        if metric.better and entry.ranked and not entry.metrics[metric.name].rank_note
        if (summary := summaries[metric.name][entry.name]) is not None
        if summary.runs >= FULL_ENTRY_RUNS
    )
    return Ranked(ranked, significant_pairs([summary for _, summary in ranked]))


def _pairs(entries: Sequence[BoardEntry], summaries: Summaries) -> tuple[Pair, ...]:
    """The difference of every two entries, of every metric that both have."""
    pairs = []
    for above, below in combinations([entry.name for entry in entries[:MAX_PAIRED]], 2):
        both = {name: (values[above], values[below]) for name, values in summaries.items()}
        metrics = {name: Difference.of(a, b) for name, (a, b) in both.items() if a and b}
        if metrics:
            pairs.append(Pair(above, below, metrics))
    return tuple(pairs)


def board_level(card: Scorecard, key: BoardKey, protocol: str = "") -> Level:
    """The lowest level of an entry's logs on a board.

    Args:
        card: the entry, which is on the board.
        key: the board.
        protocol: of the logs; the board's if empty. A missing log does not count.
    """
    logs = (card.groups.get(name, {}).get(protocol or key.protocol) for name in key.groups)
    return min((log.level for log in logs if log), key=LEVELS.index, default=VERIFIED)


def _is_verified(level: Level) -> bool:
    return LEVELS.index(level) >= LEVELS.index(VERIFIED)


def _why_not_ranked(
    level: Level, why_claimed: str, runs: int, first: MetricValue, duplicate: str | None
) -> str:
    if level == REPORTED:
        return "Reported from a publication: no logs."
    if duplicate:
        return f"Has most episodes of {duplicate}."
    if not _is_verified(level):
        return f"Claimed: {why_claimed}"
    if runs < FULL_ENTRY_RUNS:
        return f"Fewer than {FULL_ENTRY_RUNS} runs."
    return first.why if first.mean is None else ""


def _rank_note(card: Scorecard, key: BoardKey, metric: Metric, is_unlearned: bool) -> str:
    """Why an entry with a rank has none on this metric; empty if it has one."""
    if is_unlearned and metric.name == FORGETTING:
        return NOTHING_LEARNED
    for protocol in metric.needs:
        if protocol in PROTOCOLS and not _is_verified(board_level(card, key, protocol)):
            return f"the {NEEDS[protocol]} are not verified"
    return ""


def _entry(
    card: Scorecard,
    key: BoardKey,
    score: GroupScore | SuiteScore,
    duplicate: str | None,
    related: tuple[str, ...],
) -> BoardEntry:
    logs = [card.groups[name][key.protocol] for name in key.groups]
    runs = min(len(log.runs) for log in logs)
    level, metrics = board_level(card, key), BOARD_METRICS[key.protocol]
    claimed = next(filter(None, (log.why_claimed for log in logs)), "not verified.")
    why = _why_not_ranked(level, claimed, runs, score.metrics[metrics[0].name], duplicate)
    is_unlearned = learned_nothing(score.metrics)
    manifest = card.manifest
    return BoardEntry(
        name=card.name,
        title=card.title,
        level=level,
        runs=runs,
        ranked=not why,
        why=why,
        steps=manifest.protocol.steps if manifest else None,
        evaluation=manifest.protocol.evaluation if manifest else None,
        authors=manifest.authors if manifest else (),
        accepted=card.accepted,
        observes=manifest.observes if manifest else None,
        memory=manifest.memory if manifest else None,
        metrics={
            metric.name: BoardMetric(
                value.mean,
                value.low,
                value.high,
                value.why,
                rank_note=_rank_note(card, key, metric, is_unlearned),
            )
            for metric in metrics
            if (value := score.metrics[metric.name])
        },
        duplicate_of=duplicate,
        related=related,
    )


def _sorted(entries: Sequence[BoardEntry], metric: str) -> list[BoardEntry]:
    """Ranked entries, best first, then the others; an identical entry follows the one that it equals."""

    def order(entry: BoardEntry) -> tuple[bool, float, str]:
        mean = entry.metrics[metric].mean
        return (not entry.ranked, float("inf") if mean is None else -mean, entry.name)

    identical: dict[str | None, list[BoardEntry]] = {}
    for entry in sorted(entries, key=order):
        identical.setdefault(entry.duplicate_of, []).append(entry)
    return [row for entry in identical.get(None, ()) for row in (entry, *identical.get(entry.name, ()))]


def _duplicates(cards: Sequence[Scorecard], key: BoardKey) -> dict[str, str]:
    """The original of each entry that is a copy, by name. Only sequential logs can show that.

    Methods that differ between tasks alone rightly have equal single-task logs, and joint training is the
    same for them. Of identical entries the original is a verified one, then the one that was accepted first,
    then the first by name.
    """
    if key.protocol != "sequential":
        return {}

    def sketches(card: Scorecard, name: str) -> tuple[Sketch, ...]:
        log = card.groups.get(name, {}).get(key.protocol)
        return log.episode_sketches if log else ()

    def original_first(card: Scorecard) -> tuple[bool, str, str]:
        return (not _is_verified(board_level(card, key)), card.accepted or LAST_DATE, card.name)

    return duplicate_entries(
        {
            card.name: [
                tuple(f"{name} {digest}" for digest in sketch)  # groups of a suite are told apart
                for name in key.groups
                for sketch in sketches(card, name)
            ]
            for card in sorted(cards, key=original_first)
        }
    )


def board(cards: Sequence[Scorecard], key: BoardKey, references: References | None = None) -> Board:
    """One board. Ranked entries come first, best first by their first metric, then those without a rank.

    An entry with most episodes of another follows it, without a rank.

    Args:
        cards: scorecards; those that are not on the board are left out.
        key: the board.
        references: of the computed rows; the current benchmark version's where None.
    """
    references = load_references() if references is None else references
    on_board = [(card, score) for card in cards if (score := lookup(card, key)) is not None]
    by_name = {card.name: card for card, _ in on_board}
    duplicates, related = _duplicates(list(by_name.values()), key), related_entries(by_name)
    first, *others = BOARD_METRICS[key.protocol]
    entries = _sorted(
        [_entry(card, key, score, duplicates.get(card.name), related[card.name]) for card, score in on_board],
        first.name,
    )
    summaries = {
        metric.name: {
            name: estimate(card.groups, key.groups, key.protocol, metric) for name, card in by_name.items()
        }
        for metric in (first, *others)
    }
    ranked = _ranked_on(entries, summaries, first)
    ranks = {first.name: ranked.intervals(first.better)}
    for metric in others:
        ranks[metric.name] = _ranked_on(entries, summaries, metric).intervals(metric.better)
    vs_next, vs_leader = ranked.vs_next(), ranked.vs_leader()
    rows = tuple(
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
    )
    with_logs = next((card for card in by_name.values() if card.level != REPORTED), None)
    tasks = {name: with_logs.groups[name][key.protocol].tasks for name in key.groups} if with_logs else {}
    return Board(
        group=key.group,
        published=key.group in SUITES or key.group in {group.id for group in GROUPS.values()},
        protocol=key.protocol,
        budget=key.budget,
        task_conditioned=key.task_conditioned,
        ranked=sum(entry.ranked for entry in entries),
        rows=rows,
        computed=computed_rows(key, references, tasks, by_name) if tasks else (),
        pairs=_pairs(entries, summaries),
    )


def boards(cards: Sequence[Scorecard], references: References | None = None) -> BoardsDocument:
    """Every board of the scorecards. Withdrawn entries are left out.

    Args:
        cards: scorecards.
        references: of the computed rows; the current benchmark version's where None.
    """
    references = load_references() if references is None else references
    shown = [card for card in cards if not card.withdrawn]
    return BoardsDocument(
        core=core(shown), boards=tuple(board(shown, key, references) for key in board_keys(shown))
    )


def core(cards: Sequence[Scorecard]) -> CoreBoard | None:
    """The core board of the scorecards; None without an entry on it. Agents that observe the task are on it.

    Args:
        cards: scorecards; those without runs on the core, or with another budget, are left out.
    """
    on_core = [card for card in cards if not card.problems and is_on_core(card)]
    key = BoardKey(CORE, "sequential", STANDARD_BUDGET, False)
    levels = {card.name: board_level(card, key) for card in on_core}
    barred = {name: f"Has most episodes of {other}." for name, other in _duplicates(on_core, key).items()}
    for card in on_core:
        logs = (card.groups.get(name, {}).get(key.protocol) for name in key.groups)
        claimed = next(
            (log.why_claimed or "not verified." for log in logs if log and not _is_verified(log.level)), ""
        )
        if claimed:
            barred.setdefault(card.name, f"Claimed: {claimed}")
    return core_board(on_core, levels, barred)


Scores = Mapping[str, Mapping[str, GroupScore]] | Mapping[str, Mapping[str, SuiteScore]]


def _metrics(
    first: Scorecard, second: Scorecard, names: Sequence[str], protocol: str
) -> dict[str, ComparedMetric]:
    metrics = {}
    for metric in METRICS[protocol]:
        a, b = (estimate(card.groups, names, protocol, metric) for card in (first, second))
        if a is not None and b is not None:
            metrics[metric.name] = ComparedMetric(a.mean, b.mean, Difference.of(a, b))
    return metrics


def _common(first: Scorecard, second: Scorecard, scores: Scores, others: Scores) -> ComparedScores:
    """What both entries have, by group or suite and protocol, with the same budget."""
    common: ComparedScores = {}
    for name, protocols in scores.items():
        for protocol, score in protocols.items():
            other = others.get(name, {}).get(protocol)
            if other is not None and other.budget == score.budget:
                metrics = _metrics(first, second, SUITES.get(name, (name,)), protocol)
                common.setdefault(name, {})[protocol] = ComparedScore(score.budget, metrics)
    return common


def compare(first: Scorecard, second: Scorecard) -> Comparison:
    """The comparison of two scorecards.

    Intervals are Welch's for this one pair, 95 %, not corrected for multiple comparisons.

    Raises:
        BenchError: a submission has problems, or the two have no group with the same protocol and budget.
    """
    for card in (first, second):
        if card.problems:
            hint = f"Run: score {card.name}."
            raise BenchError("not-scored", "The submission has problems.", card.name, hint)
    groups = _common(first, second, first.groups, second.groups)
    if not groups:
        message = f"{first.name} and {second.name} have no group with the same protocol and budget."
        raise BenchError("nothing-to-compare", message, hint="Compare entries of one board.")
    suites = _common(first, second, first.suites, second.suites)
    return Comparison(first=first.name, second=second.name, groups=groups, suites=suites)
