"""Boards: the scorer's own, in the order of the index, and what may be said of who is first."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

from gym_extensions.catalog.budgets import BUDGETS
from gym_extensions.catalog.protocol import PROTOCOLS
from gym_extensions.scoring.leaderboard import model
from gym_extensions.scoring.scorecard.model import REPORTED, Scorecard
from gym_extensions.site.charts import strip_plot as charts
from gym_extensions.site.charts.scale import Axis
from gym_extensions.site.views.board_row import COLUMNS, Row
from gym_extensions.site.views.leader import lead
from gym_extensions.site.views.trial import Trial, group_order, group_trials, suite_trials


@dataclass(frozen=True)
class Board:
    """Entries on one group or suite, protocol and budget; task-conditioned ones have their own."""

    group: str
    protocol: str
    budget: str
    task_conditioned: bool
    suite: bool
    rows: tuple[Row, ...]

    @property
    def id(self) -> str:
        """Its anchor, for example ``hopper-gravity-v0-sequential-100k``."""
        return "-".join(
            (
                self.group,
                self.protocol,
                self.budget,
                *(("task-conditioned",) if self.task_conditioned else ()),
            )
        )

    @property
    def columns(self) -> tuple[str, ...]:
        """The names of its metrics, the one that sorts it first."""
        return COLUMNS[self.protocol]

    @property
    def unsolved_tasks(self) -> tuple[str, ...]:
        """Tasks without a ceiling, left out of every normalized mean."""
        return next((row.trial.unsolved_tasks for row in self.rows if row.trial.unsolved_tasks), ())

    @property
    def bodies(self) -> tuple[tuple[str, tuple[Row, ...]], ...]:
        """Ranked entries, then the others under a heading that says why they are not."""
        parts = [(ranked, tuple(rows)) for ranked, rows in groupby(self.rows, key=lambda row: row.ranked)]
        return tuple(("" if ranked else _not_ranked(rows), rows) for ranked, rows in parts)

    @property
    def whys(self) -> tuple[str, ...]:
        """Why values on it are missing."""
        return whys([row.trial for row in self.rows])

    @property
    def axis(self) -> Axis:
        """One scale for all that is drawn on it."""
        return axis([row.trial for row in self.rows])

    def lead(self) -> tuple[Row, str] | None:
        """The first row and how sure its lead is, in a sentence; None when nobody has a value."""
        return lead(self.rows, self.columns[0])


def whys(trials: Sequence[Trial]) -> tuple[str, ...]:
    """Why values of trials of one protocol are missing, each reason once, in order."""
    found = (trial.metric(name) for trial in trials for name in COLUMNS[trial.protocol])
    return tuple(dict.fromkeys(estimate.why for estimate in found if estimate.mean is None))


def axis(trials: Sequence[Trial]) -> Axis:
    """One scale for what is drawn of trials of one protocol: its sorting metric, and learning performance."""
    drawn = [COLUMNS[trial.protocol][0] for trial in trials[:1]] + ["learning_performance"]
    return charts.estimate_axis(trial.metric(name) for trial in trials for name in drawn)


def _not_ranked(rows: Sequence[Row]) -> str:
    reasons = dict.fromkeys(row.entry.why for row in rows)
    return f"Not ranked: {' '.join(reasons)}"


def boards(scored: Sequence[model.Board], cards: Sequence[Scorecard]) -> tuple[Board, ...]:
    """The scorer's boards by protocol, budget (longest first), suites, groups; task-conditioned last.

    A board on which nobody has logs is left out: published tables alone are compared with nothing.

    Args:
        scored: the scorer's boards.
        cards: the scorecards of their entries.
    """
    found = [_board(board, {card.name: card for card in cards}) for board in scored]
    budgets = list(BUDGETS)
    return tuple(
        sorted(
            (board for board in found if any(row.entry.trust != REPORTED for row in board.rows)),
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
        on_board = [
            trial
            for trial in (*group_trials(card), *suite_trials(card))
            if (trial.group, trial.protocol) == (board.group, board.protocol)
        ]
        rows.append(Row(card, on_board[0], entry, ranked_on))
    suite = rows[0].trial.detail is None
    return Board(board.group, board.protocol, board.budget, board.task_conditioned, suite, tuple(rows))
