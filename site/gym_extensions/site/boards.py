"""Boards: which entries are compared with each other, in what order, and what may be said of the first."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from gym_extensions.catalog.protocol import BUDGETS, FULL_ENTRY_RUNS, PROTOCOLS
from gym_extensions.site import charts
from gym_extensions.site.axis import Axis
from gym_extensions.site.document import Entry, Estimate, Trial
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


@dataclass(frozen=True)
class Row:
    """One entry on one board."""

    entry: Entry
    trial: Trial

    @property
    def lead(self) -> Estimate:
        """The metric that sorts the board."""
        return self.trial.metric(COLUMNS[self.trial.protocol][0])

    @property
    def full(self) -> bool:
        """Whether it has the runs of a full entry."""
        return len(self.trial.runs) >= FULL_ENTRY_RUNS


@dataclass(frozen=True)
class Board:
    """Entries on one group, protocol and budget; those told the task in evaluation have their own."""

    group: str
    protocol: str
    budget: str
    told: bool
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
        """Full entries, then those with fewer runs under a heading of their own."""
        full = tuple(row for row in self.rows if row.full)
        fewer = tuple(row for row in self.rows if not row.full)
        heading = f"Fewer than {FULL_ENTRY_RUNS} runs: shown, not ranked"
        return tuple((title, rows) for title, rows in (("", full), (heading, fewer)) if rows)

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

        Full entries are compared with full ones; only where there are none, the others are.
        """
        valued = [row for row in self.rows if row.lead.mean is not None]
        valued = [row for row in valued if row.full] or valued
        return (valued[0], _how_sure(valued)) if valued else None


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


def _how_sure(valued: list[Row]) -> str:
    first, *others = valued
    if not others:
        return f"It is the only {'full entry' if first.full else 'entry with a value'}."
    if first.lead.ends is None:
        return "It has one run, so nothing can be said about how sure that is."
    low = first.lead.ends[0]
    touching = [row.entry.title for row in others if row.lead.ends is None or row.lead.ends[1] >= low]
    if not touching:
        return "Its interval lies above that of every other entry."
    if len(touching) > 3:
        return f"Its interval does not lie clear of {len(touching)} others, so the order may be chance."
    return f"Its interval does not lie clear of {_listed(touching)}, so the order may be chance."


def _listed(names: list[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def boards(entries: Iterable[Entry]) -> tuple[Board, ...]:
    """Every board, by protocol, budget (longest first), group; rows by the leading metric, best first.

    Entries with the runs of a full entry stand above those with fewer, which are shown and not ranked.
    Refused submissions and budgets that are for tests alone are on no board.
    """
    found: dict[tuple[str, str, str, bool], list[Row]] = {}
    for entry in entries:
        for trial in entry.trials:
            if entry.problems or not BUDGETS[trial.budget].on_boards:
                continue
            key = (trial.group, trial.protocol, trial.budget, entry.knows("task_in_evaluation") is True)
            found.setdefault(key, []).append(Row(entry, trial))
    whole = [Board(*key, tuple(sorted(rows, key=_order))) for key, rows in found.items()]
    budgets = list(BUDGETS)
    return tuple(
        sorted(
            whole,
            key=lambda board: (
                board.told,
                PROTOCOLS.index(board.protocol),
                budgets.index(board.budget),
                place(board.group),
            ),
        )
    )


def _order(row: Row) -> tuple[bool, bool, float, str]:
    mean = row.lead.mean
    return (not row.full, mean is None, 0.0 if mean is None else -mean, row.entry.name)
