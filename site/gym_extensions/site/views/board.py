"""The boards of the scorer, in the order of the index."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

from gym_extensions.catalog.budgets import BUDGETS
from gym_extensions.catalog.protocol import PROTOCOLS
from gym_extensions.scoring.leaderboard import model
from gym_extensions.scoring.scorecard.model import REPORTED, Scorecard
from gym_extensions.site.views.board_row import COLUMNS, Row
from gym_extensions.site.views.leader import Leader, leader
from gym_extensions.site.views.trial import Trial, group_order, group_trials, suite_trials


@dataclass(frozen=True)
class Board:
    """The entries of one group or suite, protocol and budget; task-conditioned ones are on other boards."""

    group: str
    protocol: str
    budget: str
    task_conditioned: bool
    suite: bool
    rows: tuple[Row, ...]

    @property
    def id(self) -> str:
        """Its anchor, for example ``hopper-gravity-v0-sequential-100k``."""
        conditioned = ("task-conditioned",) if self.task_conditioned else ()
        return "-".join((self.group, self.protocol, self.budget, *conditioned))

    @property
    def columns(self) -> tuple[str, ...]:
        """The names of its metrics, the sorting one first."""
        return COLUMNS[self.protocol]

    @property
    def trials(self) -> tuple[Trial, ...]:
        """The trials of its entries, from top to bottom."""
        return tuple(row.trial for row in self.rows)

    @property
    def unsolved_tasks(self) -> tuple[str, ...]:
        """Tasks without a ceiling; normalized means exclude them."""
        return next((trial.unsolved_tasks for trial in self.trials if trial.unsolved_tasks), ())

    @property
    def bodies(self) -> tuple[tuple[str, tuple[Row, ...]], ...]:
        """Ranked entries, then the others under a heading with the reason why they are not ranked."""
        parts = [(ranked, tuple(rows)) for ranked, rows in groupby(self.rows, key=lambda row: row.ranked)]
        return tuple(("" if ranked else _not_ranked(rows), rows) for ranked, rows in parts)

    @property
    def reasons(self) -> tuple[str, ...]:
        """Why values on it are missing."""
        return missing_reasons(self.trials)

    def leader(self) -> Leader | None:
        """The first entry and how certain its lead is; None if no entry has a score."""
        return leader(self.rows, self.columns[0])


def missing_reasons(trials: Sequence[Trial]) -> tuple[str, ...]:
    """Why values on the boards of trials of one protocol are missing, each reason once, in order."""
    values = (trial.metric(name) for trial in trials for name in COLUMNS[trial.protocol])
    return tuple(dict.fromkeys(value.why for value in values if value.mean is None))


def _not_ranked(rows: Sequence[Row]) -> str:
    reasons = dict.fromkeys(row.entry.why for row in rows)
    return f"Not ranked: {' '.join(reasons)}"


def boards(scored: Sequence[model.Board], cards: Sequence[Scorecard]) -> tuple[Board, ...]:
    """The scorer's boards by protocol, budget (longest first), suites, groups; task-conditioned ones last.

    Boards that have only published tables without logs are omitted.

    Args:
        scored: the scorer's boards.
        cards: the scorecards of their entries.
    """
    by_name = {card.name: card for card in cards}
    budgets = list(BUDGETS)
    return tuple(
        sorted(
            (
                _board(board, by_name)
                for board in scored
                if any(entry.trust != REPORTED for entry in board.rows)
            ),
            key=lambda board: (
                board.task_conditioned,
                PROTOCOLS.index(board.protocol),
                budgets.index(board.budget),
                not board.suite,
                group_order(board.group),
            ),
        )
    )


def _board(board: model.Board, cards: dict[str, Scorecard]) -> Board:
    ranked_on = Counter(
        name for entry in board.rows for name, metric in entry.metrics.items() if metric.rank is not None
    )
    rows = []
    for entry in board.rows:
        card = cards[entry.name]
        trial = next(
            trial
            for trial in (*group_trials(card), *suite_trials(card))
            if (trial.group, trial.protocol) == (board.group, board.protocol)
        )
        rows.append(Row(card, trial, entry, ranked_on))
    suite = rows[0].trial.detail is None
    return Board(board.group, board.protocol, board.budget, board.task_conditioned, suite, tuple(rows))
