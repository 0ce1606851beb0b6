"""Boards: the scorer's own, in the order of the index, and what may be said of who is first."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import groupby

from gym_extensions.catalog.protocol import BUDGETS, PROTOCOLS
from gym_extensions.site import charts
from gym_extensions.site.axis import Axis
from gym_extensions.site.document import Entry, Estimate, Json, Trial
from gym_extensions.site.numerals import fixed, interval
from gym_extensions.site.parse import place

COLUMNS: dict[str, tuple[str, ...]] = {
    "sequential": (
        "final_performance",
        "learning_performance",
        "forgetting",
        "forward_transfer",
        "zero_shot_transfer",
    ),
    "single": ("single_task_performance",),
    "joint": ("final_performance", "spread", "worst_tenth"),
}
"""The metrics of a protocol's board; the first sorts it. Forgetting stands beside learning performance."""

RANKS_SHOWN = ("final_performance", "single_task_performance", "forgetting")


@dataclass(frozen=True)
class Row:
    """One entry on a board; ``place`` is what the scorer's board says, ``among`` how many are ranked."""

    entry: Entry
    trial: Trial
    place: Json
    among: int

    @property
    def lead(self) -> Estimate:
        """The metric that sorts the board."""
        return self.trial.metric(COLUMNS[self.trial.protocol][0])

    @property
    def ranked(self) -> bool:
        """Whether it is a full entry, which has a rank interval."""
        return bool(self.place["ranked"])

    @property
    def runs(self) -> int:
        """Its training runs; on a suite those of the group that has fewest."""
        return int(self.place["runs"])

    def rank(self, metric: str) -> tuple[int, int] | None:
        """First and last possible rank on a metric; None without one, or with nobody to rank against."""
        span = self.place["metrics"][metric]["rank"]
        return (span[0], span[1]) if span and self.among > 1 else None


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
        return self.rows[0].trial.open_tasks

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
        """The first row and how sure its lead is, in a sentence; None when nobody has a value.

        Ranked entries have the scorer's rank interval; where there are none, intervals are compared.
        """
        valued = [row for row in self.rows if row.lead.mean is not None]
        ranked = [row for row in valued if row.ranked]
        if not valued:
            return None
        return (ranked[0], _ranked(ranked, self.columns[0])) if ranked else (valued[0], _unranked(valued))


def whys(trials: Sequence[Trial]) -> tuple[str, ...]:
    """Why values of trials of one protocol are missing, each reason once, in order."""
    found = (trial.metric(name) for trial in trials for name in COLUMNS[trial.protocol])
    return tuple(dict.fromkeys(estimate.why for estimate in found if estimate.mean is None))


def numbered(reasons: Sequence[str]) -> Callable[[str], str]:
    """The number of a reason among those below a table."""
    return lambda why: str(reasons.index(why) + 1)


def axis(trials: Sequence[Trial]) -> Axis:
    """One scale for what is drawn of trials of one protocol: its sorting metric, and learning performance."""
    drawn = [COLUMNS[trial.protocol][0] for trial in trials[:1]] + ["learning_performance"]
    return charts.estimate_axis(trial.metric(name) for trial in trials for name in drawn)


def _not_ranked(rows: Sequence[Row]) -> str:
    reasons = dict.fromkeys(str(row.place.get("why", "")) for row in rows)
    return f"Not ranked: {' '.join(reasons)}"


def _ranked(ranked: Sequence[Row], metric: str) -> str:
    first, *others = ranked
    if not others:
        return "It is the only full entry."
    span = first.rank(metric) or (1, len(ranked))
    if span == (1, 1):
        return "It is ahead of every other full entry, with 95\u202f% confidence."
    below = first.place["next"]
    second = others[0].entry.title
    gap = below["difference"]
    ends = "" if gap["low"] is None else f" ({interval(gap['low'], gap['high'])})"
    start = f"It may rank from {span[0]} to {span[1]}: ahead of {second} by {fixed(gap['mean'])}{ends}"
    if below["separated"]:
        return f"{start}, which is told apart, but not of all others."
    more = below["more_runs"]
    needed = "more than 100 more runs" if more is None else f"about {more} more run{'' if more == 1 else 's'}"
    return f"{start}, which {needed} each would tell apart."


def _unranked(valued: Sequence[Row]) -> str:
    first, *others = valued
    if not others:
        return "It is the only entry with a value."
    if first.lead.ends is None:
        return "It has one run, so nothing can be said about how sure that is."
    low = first.lead.ends[0]
    touching = [row.entry.title for row in others if row.lead.ends is None or row.lead.ends[1] >= low]
    if not touching:
        return "Its interval lies above that of every other entry."
    listed = f"{len(touching)} others" if len(touching) > 3 else _listed(touching)
    return f"Its interval does not lie clear of {listed}, so the order may be chance."


def _listed(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def boards(scored: Sequence[Json], entries: Sequence[Entry]) -> tuple[Board, ...]:
    """The scorer's boards by protocol, budget (longest first), suites, groups; told the task last.

    A board on which nobody has logs is left out: published tables alone are compared with nothing.

    Args:
        scored: the boards as ``gym_extensions.scoring.board.boards`` gives them.
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
    rows = []
    for row in board["rows"]:
        entry = entries[row["name"]]
        trials = [trial for trial in (*entry.trials, *entry.suites) if trial.group == group]
        rows.append(
            Row(entry, next(trial for trial in trials if trial.protocol == protocol), row, board["ranked"])
        )
    suite = any(trial.group == group for trial in rows[0].entry.suites)
    return Board(group, protocol, board["budget"], bool(board["told_the_task"]), suite, tuple(rows))
