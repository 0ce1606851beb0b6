"""Scorecards and boards as pandas data frames. Importing this module loads pandas."""

from __future__ import annotations

from collections.abc import Iterator

import pandas as pd

from gym_extensions.scoring.leaderboard.model import Board, BoardEntry
from gym_extensions.scoring.metrics.definitions import METRICS
from gym_extensions.scoring.scorecard.model import GroupScore, Scorecard, ScorecardDocument, SuiteScore

METRIC_DTYPES = {
    "name": "str",
    "trust": "str",
    "group": "str",
    "protocol": "str",
    "budget": "str",
    "runs": "Int64",
    "metric": "str",
    "mean": "float64",
    "low": "float64",
    "high": "float64",
    "why": "str",
}
"""The columns of :func:`metrics_frame`; ``Int64`` may be missing."""

ENTRY_DTYPES = {
    "rank_first": "Int64",
    "rank_last": "Int64",
    "name": "str",
    "title": "str",
    "trust": "str",
    "evaluation": "str",
    "runs": "int64",
    "ranked": "bool",
    "why": "str",
}
"""The columns of :func:`board_frame` before those of the metrics."""

Row = tuple[object, ...]


def scores(card: Scorecard) -> Iterator[tuple[str, str, GroupScore | SuiteScore]]:
    """The scores of a scorecard with the group id or suite, and the protocol: groups before suites."""
    for groups in (card.groups, card.suites):
        for name, protocols in groups.items():
            for protocol, score in protocols.items():
                yield name, protocol, score


def _metric_rows(card: Scorecard) -> Iterator[Row]:
    for problem in card.problems:
        why = f"{problem.rule}: {problem.where}: {problem.message}"
        yield card.name, *[None] * (len(METRIC_DTYPES) - 2), why
    for name, protocol, score in scores(card):
        runs = len(score.runs) if isinstance(score, GroupScore) else None
        for metric in METRICS[protocol]:
            value = score.metrics[metric.name]
            group = (name, protocol, score.budget, runs)
            yield card.name, card.trust, *group, metric.name, value.mean, value.low, value.high, value.why


def metrics_frame(document: ScorecardDocument) -> pd.DataFrame:
    """One row per submission, group or suite, protocol and metric, with the columns of ``METRIC_DTYPES``.

    A submission with problems has one row per problem, with its name and ``why`` alone.
    """
    rows = [row for card in document.submissions for row in _metric_rows(card)]
    return pd.DataFrame(rows, columns=list(METRIC_DTYPES)).astype(METRIC_DTYPES)


def board_dtypes(protocol: str) -> dict[str, str]:
    """The columns of a board of that protocol: the entry's, and three per metric."""
    ends = [f"{metric.name}{end}" for metric in METRICS[protocol] for end in ("", "_low", "_high")]
    return ENTRY_DTYPES | dict.fromkeys(ends, "float64")


def _board_row(entry: BoardEntry, protocol: str) -> Row:
    values = [entry.metrics[metric.name] for metric in METRICS[protocol]]
    ends = [end for value in values for end in (value.mean, value.low, value.high)]
    ranks = values[0].rank or (None, None)
    names = (entry.name, entry.title, entry.trust, entry.evaluation)
    return *ranks, *names, entry.runs, entry.ranked, entry.why, *ends


def board_frame(board: Board) -> pd.DataFrame:
    """One row per entry in the order of the board, with the columns of :func:`board_dtypes`."""
    dtypes = board_dtypes(board.protocol)
    rows = [_board_row(entry, board.protocol) for entry in board.rows]
    return pd.DataFrame(rows, columns=list(dtypes)).astype(dtypes)
