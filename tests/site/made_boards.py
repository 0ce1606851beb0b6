"""Boards made from the values of runs, for the tests of boards and of their leaders."""

from typing import Any

from gym_extensions.site.board_views import BoardView, Leaderboard, shortened

from .browser import typed

FIVE = (-0.02, -0.01, 0.0, 0.01, 0.02)
"""Offsets of five runs from their mean: standard deviation .0158, interval ± .0196."""

Card = dict[str, Any]


def around(mean: float, runs: int = 5, wide: float = 1.0) -> list[float]:
    """Values of runs around a mean."""
    return [mean + wide * spread for spread in FIVE[:runs]]


def only(*cards: Card) -> BoardView:
    """The only board of these cards."""
    references = {"version": "made-up", "sha256": ""}
    whole = typed({"format": 1, "references": references, "submissions": list(cards)})
    (board,) = Leaderboard(whole.references, tuple(map(shortened, whole.submissions))).boards
    return board
