"""What all pages are made from: the references, the entries without their logs, and the boards."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from gym_extensions.scoring.leaderboard.board import boards as scored_boards
from gym_extensions.scoring.leaderboard.model import BoardsDocument
from gym_extensions.scoring.scorecard.model import ReferencesInfo, Scorecard
from gym_extensions.site.views.board import Board, boards
from gym_extensions.site.views.entrant import Entrant


@dataclass(frozen=True)
class Frame:
    """What every page needs: the references that normalize all scores, and the folder of poses, if any."""

    references: ReferencesInfo
    poses: Path | None = field(default=None, kw_only=True)


@dataclass(frozen=True)
class Leaderboard(Frame):
    """All entries, sorted by name, and their boards."""

    entrants: tuple[Entrant, ...]

    @cached_property
    def entries(self) -> tuple[Scorecard, ...]:
        """Every submission's scorecard without logs, sorted by name."""
        return tuple(entrant.card for entrant in self.entrants)

    @cached_property
    def boards(self) -> tuple[Board, ...]:
        """Every board, in the order of the overview."""
        return boards(self.scored.boards, self.entrants)

    @cached_property
    def scored(self) -> BoardsDocument:
        """The scorer's boards of all submissions without problems."""
        return scored_boards([card for card in self.entries if not card.problems])
