"""One entry on one board, and the columns that are shown of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from gym_extensions.scoring.leaderboard.model import BoardEntry
from gym_extensions.scoring.metrics.value import MetricValue
from gym_extensions.scoring.scorecard.model import Scorecard
from gym_extensions.site.views.trial import Trial

COLUMNS: dict[str, tuple[str, ...]] = {
    "sequential": (
        "final_performance",
        "learning_performance",
        "forgetting",
        "asymptotic_transfer",
        "zero_shot_transfer",
    ),
    "single": ("single_task_performance",),
    "joint": ("final_performance", "return_std", "cvar_10"),
}
"""The metrics of a protocol's board; the first sorts it. Forgetting stands beside learning performance."""

RANKS_SHOWN = ("final_performance", "single_task_performance", "forgetting")
"""The metrics whose rank intervals stand in the table; boards.json has them all."""


@dataclass(frozen=True)
class Row:
    """One entry on a board; ``ranked_on`` counts the ranked entries by metric."""

    card: Scorecard
    trial: Trial
    entry: BoardEntry
    ranked_on: Mapping[str, int]

    @property
    def lead(self) -> MetricValue:
        """The metric that sorts the board."""
        return self.trial.metric(COLUMNS[self.trial.protocol][0])

    @property
    def ranked(self) -> bool:
        """Whether the board ranks it: then it has a rank interval."""
        return self.entry.ranked

    @property
    def runs(self) -> int:
        """Its training runs; on a suite those of the group that has fewest."""
        return self.entry.runs

    @property
    def duplicate_of(self) -> str | None:
        """The entry whose results it repeats digit for digit, or None."""
        return self.entry.duplicate_of

    def rank(self, metric: str) -> tuple[int, int] | None:
        """First and last possible rank on a metric; None without one, or with nobody to rank against."""
        return self.entry.metrics[metric].rank if self.ranked_on[metric] > 1 else None

    def shown_rank(self, metric: str) -> tuple[int, int] | None:
        """The rank that stands in the table: the sorting metric's, and that of forgetting."""
        return self.rank(metric) if metric in RANKS_SHOWN else None
