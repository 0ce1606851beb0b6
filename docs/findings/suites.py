"""What fine-tuning forgets on the mean over the groups of a suite, such as the same change on four bodies."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from comparison import METRICS

from gym_extensions.catalog.groups import GROUPS
from gym_extensions.scoring.scorecard import Scorecard
from gym_extensions.scoring.statistics import Interval


@dataclass(frozen=True)
class Suite:
    """A suite, the names of its groups, and the metrics of ``METRICS``."""

    name: str
    groups: tuple[str, ...]
    values: tuple[Interval, ...]

    @property
    def forgetting(self) -> Interval:
        """Forgetting."""
        return self.values[-1]


def suites_of(card: Scorecard, budget: str) -> Iterator[Suite]:
    """The suites on which an entry has all metrics of ``METRICS`` at the budget, trained in order."""
    names = {group.id: group.name for group in GROUPS.values()}
    for name, protocols in card.suites.items():
        score = protocols.get("sequential")
        if score is None or score.budget != budget:
            continue
        values = [score.metrics[column] for column in METRICS]
        if all(value.mean is not None for value in values):
            intervals = (Interval(value.mean or 0.0, value.low, value.high) for value in values)
            yield Suite(name, tuple(names[group] for group in score.groups), tuple(intervals))
