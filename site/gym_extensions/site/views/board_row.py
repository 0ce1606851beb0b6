"""One entry on one board, and the metrics that boards show."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

from gym_extensions.scoring.leaderboard.model import BoardEntry
from gym_extensions.scoring.metrics.value import MetricValue
from gym_extensions.scoring.scorecard.model import Scorecard
from gym_extensions.site.views.entrant import SEQUENTIAL, Entrant
from gym_extensions.site.views.retention import Retention
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
"""The metrics on a protocol's board. The first sorts it; forgetting follows learning performance."""

RANKED_COLUMNS = ("final_performance", "single_task_performance", "forgetting")
"""The metrics whose rank intervals the table shows; the data of a board has them all."""


@dataclass(frozen=True)
class Row:
    """One entry on a board; ``ranked_on`` is the number of ranked entries per metric."""

    entrant: Entrant
    trial: Trial
    entry: BoardEntry
    ranked_on: Mapping[str, int]

    @property
    def card(self) -> Scorecard:
        """Its scorecard without success rates and training curves."""
        return self.entrant.card

    @cached_property
    def retention(self) -> Retention | None:
        """What it keeps of each task; None for a suite and without a sequential log."""
        detail = self.trial.detail
        return Retention(detail) if detail and self.trial.protocol == SEQUENTIAL else None

    @property
    def score(self) -> MetricValue:
        """The metric that sorts the board."""
        return self.trial.metric(COLUMNS[self.trial.protocol][0])

    @property
    def ranked(self) -> bool:
        """Whether the board ranks this entry."""
        return self.entry.ranked

    @property
    def runs(self) -> int:
        """Its number of training runs; for a suite, the minimum over its groups."""
        return self.entry.runs

    @property
    def duplicate_of(self) -> str | None:
        """The name of the entry with identical results, or None."""
        return self.entry.duplicate_of

    def rank(self, metric: str) -> tuple[int, int] | None:
        """Best and worst possible rank on a metric; None if it has none, or if no other entry is ranked."""
        return self.entry.metrics[metric].rank if self.ranked_on[metric] > 1 else None

    def shown_rank(self, metric: str) -> tuple[int, int] | None:
        """The rank that the table shows for a metric; None for a metric without ranks in the table."""
        return self.rank(metric) if metric in RANKED_COLUMNS else None

    def tied(self, metric: str) -> int:
        """The number of ranked entries from which the board's test does not separate this one."""
        rank = self.rank(metric)
        return rank[1] - rank[0] if rank else 0
