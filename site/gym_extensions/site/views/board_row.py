"""One entry on one board, and the columns that are shown of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from gym_extensions.site.document import Entry, Estimate, Json, Trial

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
"""The metrics whose rank intervals stand in the table; boards.json has them all."""


@dataclass(frozen=True)
class Row:
    """One entry on a board; ``place`` is what the scorer's board says, ``ranked_on`` how many have a rank."""

    entry: Entry
    trial: Trial
    place: Json
    ranked_on: Mapping[str, int]

    @property
    def lead(self) -> Estimate:
        """The metric that sorts the board."""
        return self.trial.metric(COLUMNS[self.trial.protocol][0])

    @property
    def ranked(self) -> bool:
        """Whether the board ranks it: then it has a rank interval."""
        return bool(self.place["ranked"])

    @property
    def runs(self) -> int:
        """Its training runs; on a suite those of the group that has fewest."""
        return int(self.place["runs"])

    @property
    def same_as(self) -> str:
        """The folder's name of the entry whose results it repeats digit for digit; empty without one."""
        return str(self.place.get("same_as", ""))

    def rank(self, metric: str) -> tuple[int, int] | None:
        """First and last possible rank on a metric; None without one, or with nobody to rank against."""
        span = self.place["metrics"][metric]["rank"]
        return (span[0], span[1]) if span and self.ranked_on[metric] > 1 else None

    def shown_rank(self, metric: str) -> tuple[int, int] | None:
        """The rank that stands in the table: the sorting metric's, and that of forgetting."""
        return self.rank(metric) if metric in RANKS_SHOWN else None
