"""What tests of boards share: the board's key, the making of an entry, and what they read of a board."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from gym_extensions.catalog.suites import SUITES
from gym_extensions.scoring.leaderboard.keys import BoardKey
from gym_extensions.scoring.leaderboard.model import Board
from gym_extensions.scoring.metrics.value import MetricValue
from gym_extensions.scoring.scorecard.model import Scorecard
from gym_extensions.scoring.scorecard.suites import suite_scores

FIVE = (0, 1, 2, 3, 4)
GROUP = "hopper-gravity-v0"
KEY = BoardKey(GROUP, "sequential", "100k", False)
Value = Callable[[str, int, int, int, int], float]
Enter = Callable[..., Scorecard]
"""Makes the scorecard of an entry whose returns lie around a level: the fixture ``enter``."""


def on_gravity(card: Scorecard, mean: float) -> Scorecard:
    """The scorecard with every group of the suite: five runs of each, with that mean and deviation 1."""
    runs = tuple(mean + step / math.sqrt(2.5) for step in range(-2, 3))
    score = card.groups[GROUP]["sequential"]
    metrics = {**score.metrics, "final_performance": MetricValue(mean=mean, runs=runs)}
    groups = {name: {"sequential": replace(score, metrics=metrics)} for name in SUITES["gravity"]}
    return replace(card, groups=groups, suites=suite_scores(groups))


def names(board: Board) -> list[str]:
    """The names of the entries, in the order of the board."""
    return [entry.name for entry in board.rows]


def final_ranks(board: Board) -> list[tuple[int, int] | None]:
    """The ranks by final performance, in the order of the board."""
    return [entry.metrics["final_performance"].rank for entry in board.rows]
