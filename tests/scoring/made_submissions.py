"""What tests of boards share: the board's key, the making of a submission, and what they read of a board."""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

from gym_extensions.catalog.groups import SUITES
from gym_extensions.metrics.values import MetricValue
from gym_extensions.scoring.ranking.boards import Board, BoardKey
from gym_extensions.scoring.scorecard import Scorecard
from gym_extensions.scoring.submission.suites import suite_scores
from gym_extensions.submissions.review import Level

FIVE = (0, 1, 2, 3, 4)
GROUP = "hopper-gravity-v0"
KEY = BoardKey(GROUP, "sequential", "100k", False)
Enter = Callable[..., Scorecard]
"""Makes the scorecard of a submission whose returns lie around a level: the fixture ``enter``."""


class Shown(NamedTuple):
    """The exit status of a command, and what it prints."""

    status: int
    out: str
    err: str


Command = Callable[..., Shown]


def on_gravity(card: Scorecard, mean: float) -> Scorecard:
    """The scorecard with every group of the suite: five runs of each, with that mean and deviation 1."""
    runs = tuple(mean + step / math.sqrt(2.5) for step in range(-2, 3))
    score = card.groups[GROUP]["sequential"]
    metrics = {**score.metrics, "final_performance": MetricValue(mean, mean - 1, mean + 1, runs)}
    groups = {name: {"sequential": replace(score, metrics=metrics)} for name in SUITES["gravity"]}
    return replace(card, groups=groups, suites=suite_scores(groups))


def at_level(card: Scorecard, level: Level, *protocols: str) -> Scorecard:
    """The scorecard with the runs of its logs (of these protocols, or all) at another level."""
    groups = {
        name: {
            protocol: replace(score, level=level, unverified=score.runs if level == "claimed" else ())
            if protocol in protocols or not protocols
            else score
            for protocol, score in scores.items()
        }
        for name, scores in card.groups.items()
    }
    return replace(card, groups=groups)


def names(board: Board) -> list[str]:
    """The names of the submissions, in the order of the board."""
    return [submission.name for submission in board.rows]


def final_ranks(board: Board) -> list[tuple[int, int] | None]:
    """The ranks by final performance, in the order of the board."""
    return [submission.metrics["final_performance"].rank for submission in board.rows]
