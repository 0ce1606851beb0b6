"""Builds boards, which rank the submissions of one group or suite, protocol and budget.

A board is made from scorecards and the references alone. What it adds (ranks and differences)
belongs to the board and may change when a submission joins; the scores are copied and never move.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import combinations

from gym_extensions.catalog.groups import GROUPS, SUITES
from gym_extensions.catalog.protocol import FULL_SUBMISSION_RUNS, PROTOCOLS
from gym_extensions.metrics import values
from gym_extensions.metrics.formulas import BOARD_METRICS, FORGETTING, NEEDS, Metric
from gym_extensions.metrics.statistics import Summary, rank_intervals, significant_pairs
from gym_extensions.metrics.values import MetricValue
from gym_extensions.references import References, load_references
from gym_extensions.scoring.ranking import boards as documents
from gym_extensions.scoring.ranking.boards import BoardKey, BoardMetric, BoardRow, Difference
from gym_extensions.scoring.ranking.computed_rows import computed_rows
from gym_extensions.scoring.ranking.copies import copy_of, duplicates, related_submissions
from gym_extensions.scoring.ranking.core_board import core_board
from gym_extensions.scoring.scorecard import GroupScore, Scorecard
from gym_extensions.scoring.submission.values import estimate
from gym_extensions.submissions.review import REPORTED, Level

MAX_PAIRED = 60
"""Submissions of a board whose differences it lists."""
Summaries = Mapping[str, Mapping[str, Summary | None]]
"""The summary over runs by metric and submission; None where the submission has no value."""


def boards(cards: Sequence[Scorecard], references: References | None = None) -> documents.BoardsDocument:
    """Every board of the scorecards. Withdrawn submissions are on none.

    ``references`` are those of the computed rows, the current benchmark version's where None.
    """
    references = references or load_references()
    made = tuple(board(cards, key, references) for key in documents.board_keys(cards))
    return documents.BoardsDocument(core=core_board(cards), boards=made)


def board(cards: Sequence[Scorecard], key: BoardKey, references: References | None = None) -> documents.Board:
    """One board. Ranked submissions come first, best first by their first metric, then those without a rank.

    A submission with most episodes of another follows it, without a rank. Scorecards that are not on the
    board are left out. ``references`` are as in :func:`boards`.
    """
    references = references or load_references()
    by_name = {card.name: card for card in cards if documents.lookup(card, key)}
    copies, related = duplicates(list(by_name.values()), key), related_submissions(by_name)
    metrics = BOARD_METRICS[key.protocol]
    first = metrics[0]
    summaries = {
        metric.name: {
            name: estimate(card.groups, key.groups, key.protocol, metric) for name, card in by_name.items()
        }
        for metric in metrics
    }
    made = [
        _submission(
            card, key, copies.get(name), related[name], {each: of[name] for each, of in summaries.items()}
        )
        for name, card in by_name.items()
    ]
    submissions = _sorted(made, first)
    ranked = {metric.name: _ranked_on(submissions, summaries, metric) for metric in metrics}
    significant = {name: significant_pairs(tuple(values.values())) for name, values in ranked.items()}
    ranks = {}
    for metric in metrics:
        values = tuple(ranked[metric.name].values())
        found = rank_intervals(values, significant[metric.name], metric.better)
        ranks[metric.name] = dict(zip(ranked[metric.name], found, strict=True))
    names = list(ranked[first.name])

    def versus(place: int, other: int) -> documents.Versus:
        """The ranked submission at a place against the one at another place."""
        above, below = (ranked[first.name][names[index]] for index in sorted((place, other)))
        separated = bool(significant[first.name][place, other])
        return documents.Versus(names[other], Difference.of(above, below), separated)

    vs_next = {name: versus(place, place + 1) for place, name in enumerate(names[:-1])}
    vs_leader = {name: versus(place, 0) for place, name in enumerate(names) if place}

    def with_ranks(submission: BoardRow) -> BoardRow:
        name, metrics = submission.name, submission.metrics.items()
        ranked = {each: replace(value, rank=ranks[each].get(name)) for each, value in metrics}
        return replace(submission, metrics=ranked, vs_next=vs_next.get(name), vs_leader=vs_leader.get(name))

    with_logs = next((card for card in by_name.values() if card.level != REPORTED), None)
    tasks = {name: with_logs.groups[name][key.protocol].tasks for name in key.groups} if with_logs else {}
    return documents.Board(
        group=key.group,
        published=key.group in SUITES or key.group in {group.id for group in GROUPS.values()},
        protocol=key.protocol,
        budget=key.budget,
        task_conditioned=key.task_conditioned,
        ranked=sum(submission.ranked for submission in submissions),
        rows=tuple(map(with_ranks, submissions)),
        computed=computed_rows(key, references, tasks, by_name) if tasks else (),
        pairs=_pairs(submissions, summaries),
    )


def _ranked_on(submissions: Sequence[BoardRow], summaries: Summaries, metric: Metric) -> dict[str, Summary]:
    """The submissions, by name in the order of the board, that it ranks on a metric: with enough runs."""
    return {
        submission.name: summary
        for submission in submissions
        if metric.better and submission.ranked and not submission.metrics[metric.name].rank_note
        if (summary := summaries[metric.name][submission.name]) is not None
        if summary.runs >= FULL_SUBMISSION_RUNS
    }


def _pairs(submissions: Sequence[BoardRow], summaries: Summaries) -> tuple[documents.Pair, ...]:
    """The difference of every two submissions, of every metric that both have."""
    pairs = []
    for above, below in combinations([submission.name for submission in submissions[:MAX_PAIRED]], 2):
        both = {name: (values[above], values[below]) for name, values in summaries.items()}
        metrics = {name: Difference.of(a, b) for name, (a, b) in both.items() if a and b}
        if metrics:
            pairs.append(documents.Pair(above, below, metrics))
    return tuple(pairs)


def _why_not_ranked(logs: Sequence[GroupScore], level: Level, first: MetricValue, copied: str | None) -> str:
    if level == REPORTED:
        return "Reported from a publication: no logs."
    if copied:
        return copy_of(copied)
    if not documents.is_verified(level):
        return f"Claimed: {next(filter(None, (log.why_claimed for log in logs)), 'not verified.')}"
    if min(len(log.runs) for log in logs) < FULL_SUBMISSION_RUNS:
        return f"Fewer than {FULL_SUBMISSION_RUNS} runs."
    return first.why if first.mean is None else ""


def _rank_note(
    card: Scorecard, key: BoardKey, metric: Metric, summary: Summary | None, is_unlearned: bool
) -> str:
    """Why a submission with a rank and a value has no rank on this metric; empty if it has one."""
    if is_unlearned and metric is FORGETTING:
        return values.NOTHING_LEARNED
    for protocol in metric.needs:
        if protocol in PROTOCOLS and not documents.is_verified(documents.board_level(card, key, protocol)):
            return f"the {NEEDS[protocol]} are not verified"
    return (
        f"fewer than {FULL_SUBMISSION_RUNS} runs" if summary and summary.runs < FULL_SUBMISSION_RUNS else ""
    )


def _submission(
    card: Scorecard,
    key: BoardKey,
    copied: str | None,
    related: tuple[str, ...],
    summaries: Mapping[str, Summary | None],
) -> BoardRow:
    logs, score = [card.groups[name][key.protocol] for name in key.groups], documents.lookup(card, key)
    assert score is not None, "it is on the board"
    level, metrics = documents.board_level(card, key), BOARD_METRICS[key.protocol]
    why = _why_not_ranked(logs, level, score.metrics[metrics[0].name], copied)
    is_unlearned = values.learned_nothing(score.metrics)
    manifest = card.manifest
    return BoardRow(
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
            each.name: BoardMetric.of(
                score.metrics[each.name], _rank_note(card, key, each, summaries[each.name], is_unlearned)
            )
            for each in metrics
        },
        duplicate_of=copied,
        related=related,
    )


def _sorted(submissions: Sequence[BoardRow], metric: Metric) -> list[BoardRow]:
    """Ranked submissions, best first, then the others; an identical one follows its original."""
    identical: dict[str | None, list[BoardRow]] = {}
    for submission in documents.best_first(submissions, metric):
        identical.setdefault(submission.duplicate_of, []).append(submission)
    return [
        row
        for submission in identical.get(None, ())
        for row in (submission, *identical.get(submission.name, ()))
    ]
