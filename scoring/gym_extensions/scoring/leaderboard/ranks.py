"""Ranks of the entries of a board on one metric, and comparisons of single pairs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from gym_extensions.catalog.protocol import FULL_ENTRY_RUNS
from gym_extensions.scoring.leaderboard.keys import BoardKey
from gym_extensions.scoring.leaderboard.model import BoardEntry, Difference, VersusLeader, VersusNext
from gym_extensions.scoring.metrics.metric import Metric
from gym_extensions.scoring.scorecard.estimates import estimate
from gym_extensions.scoring.scorecard.model import Scorecard
from gym_extensions.scoring.statistics.intervals import Summary, subtract, to_interval
from gym_extensions.scoring.statistics.ranking import rank_intervals, runs_to_separate
from gym_extensions.scoring.statistics.student_t import two_sided_p
from gym_extensions.scoring.statistics.welch import Mask, holm, significant_pairs, welch


@dataclass(frozen=True)
class Ranked:
    """The entries that a board ranks on one metric, in the order of the board.

    Attributes:
        entries: name and summary over runs of each.
        significant: M × M, True where the board's test separates two entries.
    """

    entries: tuple[tuple[str, Summary], ...]
    significant: Mask

    def intervals(self, better: str) -> dict[str, tuple[int, int]]:
        """The rank interval of each entry by name."""
        if not self.entries:
            return {}
        names, summaries = zip(*self.entries, strict=True)
        return dict(zip(names, rank_intervals(summaries, self.significant, better), strict=True))

    def vs_next(self) -> dict[str, VersusNext]:
        """Each entry but the last against the next."""
        return {
            above[0]: _versus_next(above, below, bool(self.significant[index, index + 1]), len(self.entries))
            for index, (above, below) in enumerate(pairwise(self.entries))
        }

    def vs_leader(self) -> dict[str, VersusLeader]:
        """Each entry but the first against the first, with Holm's correction over these M − 1 tests."""
        if len(self.entries) < 2:
            return {}
        (leader, first), *others = self.entries
        statistics = [welch((first, other)) for _, other in others]
        t, df = (np.concatenate(column) for column in zip(*statistics, strict=True))
        separated = holm(two_sided_p(t, df)).tolist()
        return {
            name: VersusLeader(leader, Difference.of(to_interval(subtract(first, other))), apart)
            for (name, other), apart in zip(others, separated, strict=True)
        }


def ranked_on(
    entries: Sequence[BoardEntry], cards: Mapping[str, Scorecard], key: BoardKey, metric: Metric
) -> Ranked:
    """The ranked entries that have a value of the metric over enough runs, each pair compared."""
    ranked = tuple(
        (entry.name, summary)
        for entry in entries
        if metric.better and entry.ranked and not entry.metrics[metric.name].rank_note
        if (summary := estimate(cards[entry.name].groups, key.groups, key.protocol, metric)) is not None
        if summary.runs >= FULL_ENTRY_RUNS
    )
    return Ranked(ranked, significant_pairs([summary for _, summary in ranked]))


def _versus_next(
    above: tuple[str, Summary], below: tuple[str, Summary], separated: bool, entries: int
) -> VersusNext:
    """A ranked entry against the next, with the interval of the pair and the runs to separate them."""
    gap = subtract(above[1], below[1])
    needed = None if separated else runs_to_separate(gap, entries)
    more = None if needed is None else max(1, needed - min(above[1].runs, below[1].runs))
    return VersusNext(below[0], Difference.of(to_interval(gap)), separated, 0 if separated else more)
