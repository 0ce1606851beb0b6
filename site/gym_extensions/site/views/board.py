"""The boards of the scorer, in the order of the overview."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from gym_extensions.catalog.budgets import BUDGETS
from gym_extensions.catalog.protocol import PROTOCOLS
from gym_extensions.catalog.suites import SUITES
from gym_extensions.scoring.leaderboard import model
from gym_extensions.scoring.scorecard.model import REPORTED
from gym_extensions.site.text.labels import VERIFIED, level
from gym_extensions.site.views.board_row import COLUMNS, Row
from gym_extensions.site.views.entrant import SEQUENTIAL, Entrant
from gym_extensions.site.views.leader import Leader, leader
from gym_extensions.site.views.trial import Trial, group_order


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
        """Its name, for example ``hopper-gravity-v0-sequential-100k``."""
        conditioned = ("task-conditioned",) if self.task_conditioned else ()
        return "-".join((self.group, self.protocol, self.budget, *conditioned))

    @property
    def columns(self) -> tuple[str, ...]:
        """The names of its metrics, the sorting one first."""
        return COLUMNS[self.protocol]

    @cached_property
    def trials(self) -> tuple[Trial, ...]:
        """The trials of its entries, from top to bottom."""
        return tuple(row.trial for row in self.rows)

    @property
    def ranked(self) -> int:
        """The number of ranked entries."""
        return sum(row.ranked for row in self.rows)

    @property
    def verified(self) -> int:
        """The number of entries of which at least a sample was replayed."""
        return sum(level(row.card) in VERIFIED for row in self.rows)

    @cached_property
    def unsolved_tasks(self) -> tuple[str, ...]:
        """Tasks without a ceiling; normalized means exclude them."""
        return next((trial.unsolved_tasks for trial in self.trials if trial.unsolved_tasks), ())

    @cached_property
    def reasons(self) -> tuple[str, ...]:
        """Why values on it are missing."""
        return missing_reasons(self.trials)

    @cached_property
    def leader(self) -> Leader | None:
        """The first entry and how certain its lead is; None if no entry has a score."""
        return leader(self.rows, self.columns[0])

    @property
    def best(self) -> Row | None:
        """The first ranked entry. Without a rank, nothing proves that an entry is the best."""
        return next((row for row in self.rows if row.ranked), None)

    @cached_property
    def least_forgetting(self) -> Row | None:
        """The ranked entry that forgets least of those that learned something."""
        rows = [
            row
            for row in self.rows
            if self.protocol == SEQUENTIAL
            and row.ranked
            and row.trial.metric("forgetting").mean is not None
            and not row.trial.learned_nothing
        ]
        return min(
            rows, key=lambda row: (row.trial.metric("forgetting").mean or 0.0, row.entry.name), default=None
        )

    @property
    def why_no_rank(self) -> str:
        """The reason why the first entry has no rank; empty if it has one."""
        return self.rows[0].entry.why

    @property
    def why_no_score(self) -> str:
        """The reason why no entry has a score."""
        return next((row.score.why for row in self.rows if row.score.why), "No entry has a score.")


def missing_reasons(trials: Sequence[Trial]) -> tuple[str, ...]:
    """Why values on the boards of trials of one protocol are missing, each reason once, in order."""
    values = (trial.metric(name) for trial in trials for name in COLUMNS[trial.protocol])
    return tuple(dict.fromkeys(value.why for value in values if value.mean is None))


def boards(scored: Sequence[model.Board], entrants: Sequence[Entrant]) -> tuple[Board, ...]:
    """The scorer's boards by protocol, budget (longest first), suites, groups; task-conditioned ones last.

    Boards that have only published tables without logs are omitted.

    Args:
        scored: the scorer's boards.
        entrants: their entries.
    """
    by_name = {entrant.card.name: entrant for entrant in entrants}
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


def _board(board: model.Board, entrants: dict[str, Entrant]) -> Board:
    ranked_on = Counter(
        name for entry in board.rows for name, metric in entry.metrics.items() if metric.rank is not None
    )
    suite = board.group in SUITES
    rows = []
    for entry in board.rows:
        entrant = entrants[entry.name]
        scores = entrant.card.suites if suite else entrant.card.groups
        trial = Trial(board.group, board.protocol, scores[board.group][board.protocol])
        rows.append(Row(entrant, trial, entry, ranked_on))
    return Board(board.group, board.protocol, board.budget, board.task_conditioned, suite, tuple(rows))
