"""Boards made from the values of runs, for the tests of boards and of their leaders."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from gym_extensions.site.leaderboard import Leaderboard
from gym_extensions.site.views.board import Board
from gym_extensions.site.views.entrant import entrant

from ..browser import typed

FIVE = (-0.02, -0.01, 0.0, 0.01, 0.02)
"""Offsets of five runs from their mean: standard deviation .0158, interval ± .0196."""
QUANTILES = {2: 12.706, 3: 4.303, 4: 3.182, 5: 2.776}
"""t(.975, N − 1), three digits, from a printed table."""

Card = dict[str, Any]
Make = Callable[..., Card]


def estimate(runs: list[float]) -> Card:
    """A metric with its interval."""
    mean = sum(runs) / len(runs)
    if len(runs) == 1:
        return {"mean": mean, "low": None, "high": None, "runs": runs}
    variance = sum((run - mean) ** 2 for run in runs) / (len(runs) - 1)
    half = QUANTILES[len(runs)] * (variance / len(runs)) ** 0.5
    return {"mean": mean, "low": mean - half, "high": mean + half, "runs": runs}


def around(mean: float, runs: int = 5, wide: float = 1.0) -> list[float]:
    """Values of runs around a mean."""
    return [mean + wide * spread for spread in FIVE[:runs]]


def boards_of(*cards: Card) -> tuple[Board, ...]:
    """The boards of these cards."""
    references = {"version": "made-up", "provisional": False, "sha256": ""}
    return leaderboard({"format": 1, "references": references, "submissions": list(cards)}).boards


def leaderboard(document: Card) -> Leaderboard:
    """The leaderboard of these JSON values."""
    whole = typed(document)
    return Leaderboard(whole.references, tuple(map(entrant, whole.submissions)))


def only(*cards: Card) -> Board:
    """The only board of these cards."""
    (board,) = boards_of(*cards)
    return board


def names(board: Board) -> list[str]:
    """Its entries from top to bottom."""
    return [row.entry.name for row in board.rows]
