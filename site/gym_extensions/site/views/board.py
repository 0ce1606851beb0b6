"""Boards: the scorer's own, in the order of the index, and what may be said of who is first."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

from gym_extensions.catalog.budgets import BUDGETS
from gym_extensions.catalog.protocol import PROTOCOLS
from gym_extensions.site.charts import strip_plot as charts
from gym_extensions.site.charts.scale import Axis
from gym_extensions.site.document import Entry, Json, Trial
from gym_extensions.site.parse import place
from gym_extensions.site.views.board_row import COLUMNS, Row
from gym_extensions.site.views.leader import lead


@dataclass(frozen=True)
class Board:
    """Entries on one group or suite, protocol and budget; those told the task have their own."""

    group: str
    protocol: str
    budget: str
    told: bool
    suite: bool
    rows: tuple[Row, ...]

    @property
    def id(self) -> str:
        """Its anchor, for example ``hopper-gravity-v0-sequential-100k``."""
        return "-".join((self.group, self.protocol, self.budget, *(("told",) if self.told else ())))

    @property
    def columns(self) -> tuple[str, ...]:
        """The names of its metrics, the one that sorts it first."""
        return COLUMNS[self.protocol]

    @property
    def open_tasks(self) -> tuple[str, ...]:
        """Tasks without a ceiling, left out of every normalised mean."""
        return next((row.trial.open_tasks for row in self.rows if row.trial.open_tasks), ())

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
    reasons = dict.fromkeys(str(row.place.get("why", "")) for row in rows)
    return f"Not ranked: {' '.join(reasons)}"


def boards(scored: Sequence[Json], entries: Sequence[Entry]) -> tuple[Board, ...]:
    """The scorer's boards by protocol, budget (longest first), suites, groups; told the task last.

    A board on which nobody has logs is left out: published tables alone are compared with nothing.

    Args:
        scored: the boards as ``gym_extensions.scoring.leaderboard.board.boards`` gives them.
        entries: the entries that are on them.
    """
    found = [_board(board, {entry.name: entry for entry in entries}) for board in scored]
    budgets = list(BUDGETS)
    return tuple(
        sorted(
            (board for board in found if any(row.entry.trust != "reported" for row in board.rows)),
            key=lambda board: (
                board.told,
                PROTOCOLS.index(board.protocol),
                budgets.index(board.budget),
                not board.suite,
                place(board.group),
            ),
        )
    )


def _board(board: Json, entries: dict[str, Entry]) -> Board:
    group, protocol = board["group"], board["protocol"]
    ranked_on = Counter(
        name for row in board["rows"] for name, score in row["metrics"].items() if score["rank"] is not None
    )
    rows = []
    for row in board["rows"]:
        entry = entries[row["name"]]
        trials = [trial for trial in (*entry.trials, *entry.suites) if trial.group == group]
        trial = next(trial for trial in trials if trial.protocol == protocol)
        rows.append(Row(entry, trial, row, ranked_on))
    suite = any(trial.group == group for trial in rows[0].entry.suites)
    return Board(group, protocol, board["budget"], bool(board["told_the_task"]), suite, tuple(rows))
